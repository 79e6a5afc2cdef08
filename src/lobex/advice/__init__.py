"""Advice: which speeds and depths to take, and what measured cuts say of a model."""
