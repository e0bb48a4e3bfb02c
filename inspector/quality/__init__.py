"""The quality tab: evidence of every joint over time, and tracking with QuaMo."""
