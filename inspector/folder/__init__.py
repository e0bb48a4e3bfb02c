"""The clips of a folder: analysed in the background, in the order of their severity."""
