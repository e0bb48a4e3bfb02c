"""Quality measures of a motion without ground truth. A high value is not proof of an error."""
