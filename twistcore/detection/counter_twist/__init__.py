"""Find jumps in which a parent and its child rotate in opposite directions, and pair them."""
