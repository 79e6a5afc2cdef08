"""The periodic motion that a forced stable system comes to, and what its cut does along it."""
