"""What is open: the document, how it is read, kept, exported and played, and the clips' queue."""
