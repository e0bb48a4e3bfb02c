"""Counter-rotation of a parent and its child: where it starts, where it ends, and its angle."""
