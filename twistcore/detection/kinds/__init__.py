"""The kinds of error: one file per kind, named after the constant, with a description `KIND`."""
