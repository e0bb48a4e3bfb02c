"""Analyse one clip: detect and correct errors, measure quality and severity, explain results."""
