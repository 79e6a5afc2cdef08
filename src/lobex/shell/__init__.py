"""The command line: a thin shell over the same verbs. Nothing here imports JAX before the arguments are read."""
