"""The clip formats that are registered, one in each file."""
