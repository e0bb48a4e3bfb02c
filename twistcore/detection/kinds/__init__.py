"""The kinds of error. Each file is named after the kind and contains its description `KIND`."""
