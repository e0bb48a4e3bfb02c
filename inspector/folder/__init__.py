"""The clips of a folder: analysed in the background and listed by severity."""
