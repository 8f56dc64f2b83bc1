"""Rigid bodies by other engines, as far as they are installed; each with friction, without sleep, on one thread."""
