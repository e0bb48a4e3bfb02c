"""Remove errors from a motion, and compute the corrected clip."""
