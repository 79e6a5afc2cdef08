"""Evaluation over whole grids, in chunks of bounded memory."""
