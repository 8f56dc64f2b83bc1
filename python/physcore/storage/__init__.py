"""Files: their names and formats, the archive of checkpoints and recordings, and the rules for what is in them."""
