"""Skeletons and their motion: rotations, chains, limbs, people and twist signals."""
