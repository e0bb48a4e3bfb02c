"""The default detector: how a parent and its child twist against each other, frame by frame."""
