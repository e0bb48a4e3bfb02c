"""Evaluate the methods: benchmarks, exercises and training; a review does not need this package."""
