"""What leaves the program: the corrected clip, what differs in it, markers."""
