"""The 3D view, in which the bodies of the bones make roll visible."""
