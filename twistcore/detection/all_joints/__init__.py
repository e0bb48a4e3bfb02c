"""Errors of single joints anywhere in the body (spikes and jumps), and steps of the whole body."""
