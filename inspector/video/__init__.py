"""The witness video of a clip, shown next to the 3D view."""
