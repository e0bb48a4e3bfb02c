"""Measure the quality of a motion without ground truth. A high value does not prove an error."""
