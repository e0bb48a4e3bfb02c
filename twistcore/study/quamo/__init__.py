"""Synthetic noise, pose errors, tables and training of networks for QuaMo [Le26 §4]."""
