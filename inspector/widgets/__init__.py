"""General-purpose widgets, which are independent of the rest of the program."""
