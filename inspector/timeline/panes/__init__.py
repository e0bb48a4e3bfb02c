"""The panes of the timeline. Each file of this folder defines one pane, named `plot`."""
