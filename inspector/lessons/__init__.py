"""Guides for learning the program: the tour, lessons and exercises."""
