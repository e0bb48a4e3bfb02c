"""Counter-rotation of a parent and its child, with its start, end and angle."""
