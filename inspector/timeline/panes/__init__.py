"""The panes of the timeline. Each file in this folder defines one pane in the variable `plot`."""
