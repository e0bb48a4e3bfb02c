"""The default detector, which measures how a parent and its child twist against each other."""
