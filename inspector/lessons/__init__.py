"""The parts of the window that teach: the tour, lessons, exercises and the scores of a class."""
