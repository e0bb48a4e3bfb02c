"""Panels of the window: the tables, the forms and the interval's card."""
