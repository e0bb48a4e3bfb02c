"""The witness video: a video of the same take as the clip, shown next to the 3D view."""
