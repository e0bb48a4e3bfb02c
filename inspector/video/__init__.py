"""The witness video of a clip, which is shown next to the 3D view."""
