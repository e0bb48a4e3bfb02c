"""The registered clip formats, with a file for each."""
