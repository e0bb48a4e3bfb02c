"""The parts of the window that teach the program: the tour, lessons and exercises."""
