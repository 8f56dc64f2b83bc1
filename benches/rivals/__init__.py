"""The opponents: the same work, done as well as we can with NumPy and with Numba, without audit or divergence check."""
