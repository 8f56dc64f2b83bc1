"""Files: names and formats, the archive of checkpoints and recordings, and the rules for its content."""
