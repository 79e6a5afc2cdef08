"""Characteristic roots of one contact with constant coefficients: found, followed along the gain, and counted."""
