"""Command lines: thin shells around the core."""
