"""Views, moving cameras, and the framing of the picture."""
