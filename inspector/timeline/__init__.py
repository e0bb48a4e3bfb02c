"""The timeline: curves, strength with τ, intervals, and the overview of the clip."""
