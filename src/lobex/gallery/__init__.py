"""The figures of the thesis, one module each, made with lobex' public names alone."""
