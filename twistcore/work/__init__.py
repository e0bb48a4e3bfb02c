"""Worker processes, progress and memory limits for long computations."""
