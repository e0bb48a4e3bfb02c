"""Long work: worker processes, progress and memory limits."""
