"""The open document, and classes and functions to read, save, export and play it."""
