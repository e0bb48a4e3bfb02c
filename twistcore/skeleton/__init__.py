"""Rotations, skeletons and motions; finding limbs and chains; twist signals."""
