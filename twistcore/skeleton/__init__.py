"""Skeletons and their motion, with rotations, joint names, limbs and chains, and their twist."""
