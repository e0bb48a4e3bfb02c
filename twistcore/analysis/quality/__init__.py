"""Quality measures of a motion without ground truth. A high value alone is not an error."""
