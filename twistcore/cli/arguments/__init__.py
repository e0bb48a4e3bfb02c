"""Define the arguments of every command without importing numpy, scipy or the commands' code."""
