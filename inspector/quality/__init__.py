"""The quality tab, with measures of each joint's motion over time, and tracking with QuaMo."""
