"""Skeletons and their motion: rotations, joint names, limbs and chains, and their twist."""
