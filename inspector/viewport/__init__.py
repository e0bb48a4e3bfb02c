"""The 3D view: oriented bones that make roll visible."""
