"""The open document: reading, saving, exporting and playing it."""
