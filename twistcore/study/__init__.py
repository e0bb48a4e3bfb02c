"""Evaluate the methods: benchmarks, exercises and training, which a review does not need."""
