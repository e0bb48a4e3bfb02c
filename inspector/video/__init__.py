"""The witness video that is shown next to the 3D view, with its reader and its panel."""
