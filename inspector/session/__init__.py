"""The open document, with functions to read, save, export and play it."""
