"""The registered clip formats, one file each."""
