"""Marches in time: the same structures under contact and delay, step by step, with lanes side by side."""
