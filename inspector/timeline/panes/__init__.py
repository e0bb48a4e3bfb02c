"""The panes of the time line, one file each: what it exports as `plot` is a pane."""
