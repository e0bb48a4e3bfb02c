"""The 3D view, in which oriented bones make roll visible."""
