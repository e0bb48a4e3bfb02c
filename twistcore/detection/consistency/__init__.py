"""The default detector, which measures how parent and child twist against each other."""
