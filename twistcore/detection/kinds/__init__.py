"""The kinds of error, a file each: its name is the constant's, its KIND what is shown of it."""
