"""Counter-rotation of a parent and its child: where it starts and ends, and by how much."""
