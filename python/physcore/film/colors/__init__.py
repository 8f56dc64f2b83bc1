"""Themes, color maps, and color samples for palettes."""
