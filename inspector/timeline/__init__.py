"""The timeline: plots of a chain's angles and error strength, and an overview of the clip."""
