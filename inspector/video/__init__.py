"""The witness video shown next to the 3D view: its reader and its panel."""
