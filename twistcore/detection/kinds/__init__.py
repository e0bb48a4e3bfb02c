"""The kinds of error: one file each, named after the constant, with its description as KIND."""
