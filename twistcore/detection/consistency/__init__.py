"""The consistency detector, which finds opposite rotations of a parent and its child."""
