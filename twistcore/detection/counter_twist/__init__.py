"""Find jumps in which a parent and its child turn in opposite directions, and pair them."""
