"""Panels of the window: the tables, the forms, and the card of the selected interval."""
