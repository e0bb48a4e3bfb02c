"""The quality tab: measures of each joint's motion over time, and tracking with QuaMo."""
