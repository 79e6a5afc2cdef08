"""Frequency responses, modal tables and cuts from files, and modes fitted to what was measured."""
