"""Structures: what vibrates, reduced to modes seen at the contact."""
