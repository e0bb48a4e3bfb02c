"""Compare the review of the open clip with another reviewer's review."""
