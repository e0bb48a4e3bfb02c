"""Long work: other processes, how far they are, and the memory they may take."""
