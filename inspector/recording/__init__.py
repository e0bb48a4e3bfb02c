"""Films and pictures of the 3D view with the curves."""
