"""The timeline: plots of angles and of the strength with τ, intervals, and an overview."""
