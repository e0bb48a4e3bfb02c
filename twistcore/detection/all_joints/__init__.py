"""Find spikes and jumps of any joint, jumps in position, and steps of the whole body."""
