"""Errors of single joints, wherever they are in the body: spikes, jumps, and steps of the body."""
