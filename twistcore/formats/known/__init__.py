"""Registered clip formats, one file for each."""
