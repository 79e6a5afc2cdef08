"""Monodromy operators: the map of a delay system's state over one delay, as a matrix."""
