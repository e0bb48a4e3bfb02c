"""Measure and train QuaMo: synthetic noise, pose errors, tables and networks [Le26 §4]."""
