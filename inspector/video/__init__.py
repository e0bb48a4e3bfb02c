"""A witness video beside the 3D view: reading it, and the panel that shows it."""
