"""Skeletons and their motion: rotations, angles, chains, limbs, people, names and twist signals."""
