"""The curves that show why an interval is listed, in one file per kind of error."""
