"""Analyse one clip: detection, correction, quality, and decomposition of rotations."""
