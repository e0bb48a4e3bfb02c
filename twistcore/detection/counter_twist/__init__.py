"""Counter-rotation of a parent and its child, with its start, its end and its angle."""
