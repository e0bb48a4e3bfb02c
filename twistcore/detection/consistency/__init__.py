"""The consistency detector, which finds opposite turns of a parent and its child."""
