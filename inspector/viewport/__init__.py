"""The 3D view: oriented bones in which roll is plain to see."""
