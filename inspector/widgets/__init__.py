"""General-purpose widgets and helpers that do not depend on the rest of the program."""
