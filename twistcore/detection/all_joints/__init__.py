"""Spikes and jumps of single joints anywhere in the body, and steps of the whole body."""
