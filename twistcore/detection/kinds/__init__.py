"""The kinds of error: one file per kind, named after its constant, with the description KIND."""
