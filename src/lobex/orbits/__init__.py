"""Orbits: the periodic motion that a forced stable system comes to."""
