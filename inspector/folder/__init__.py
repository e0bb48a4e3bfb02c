"""Analyse the clips of a folder in the background, and list them by severity."""
