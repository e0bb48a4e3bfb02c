"""Guides through the program: the tour, lessons and exercises."""
