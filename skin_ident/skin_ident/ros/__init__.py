"""Live identification, the identify action, and the demo."""
