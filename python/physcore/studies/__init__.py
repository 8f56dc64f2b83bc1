"""Studies that take many runs: accuracy, limits of stability, and error against time."""
