"""The 3D view, in which the shapes of the bones make their roll visible."""
