"""The quality tab: measures of every joint over time, and tracking with QuaMo."""
