"""The curves that show why an interval is listed: one file per kind of error."""
