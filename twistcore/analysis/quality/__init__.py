"""What can be told of a motion without a truth. None of it is an error."""
