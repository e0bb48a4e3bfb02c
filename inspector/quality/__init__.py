"""The quality tab: measures of the motion of each joint, and smoothing or tracking of joints."""
