"""Guides for learning the program, with the tour, lessons and exercises."""
