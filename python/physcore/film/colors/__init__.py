"""Colors of themes, color maps, and samples for palettes."""
