"""Floquet multipliers of monodromy operators: all of them, the dominant one, and the frequency it stands for."""
