"""The panes of the timeline; each file of this folder defines one pane, named `plot`."""
