"""The time line: curves, strength with τ, interval regions, the overview of the clip."""
