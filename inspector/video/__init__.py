"""The witness video next to the 3D view: its reader and its panel."""
