"""The open document, and functions to read, save, export and play it."""
