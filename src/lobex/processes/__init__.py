"""Processes: how a structure is fed back its own past, as delay systems."""
