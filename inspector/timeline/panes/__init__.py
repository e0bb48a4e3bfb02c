"""The panes of the time line, one file each, which exports its pane as `plot`."""
