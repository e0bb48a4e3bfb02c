"""Measure and train QuaMo: noise, errors, tables, networks [Le26 §4]."""
