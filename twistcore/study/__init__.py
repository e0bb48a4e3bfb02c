"""Benchmarks, class exercises and the comparison of QuaMo with other filters.

Reviewing clips does not need this package.
"""
