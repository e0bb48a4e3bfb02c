"""Record films and pictures of the 3D view, the curves and the equations."""
