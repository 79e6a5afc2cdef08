"""Stability limits: the gain at which motion no longer dies out, as a function of speed."""
