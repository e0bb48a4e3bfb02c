"""The curves that show why an interval is reported, with one file per kind of error."""
