"""The arguments of every command, defined without loading numpy, scipy or the commands' code."""
