"""Measures of a motion without ground truth. None of them is an error."""
