"""The parts of the window that teach: the tour, lessons, exercises and scores of a class."""
