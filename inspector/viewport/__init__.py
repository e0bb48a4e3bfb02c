"""The 3D view. Its oriented bones make roll visible."""
