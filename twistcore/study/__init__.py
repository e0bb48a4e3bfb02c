"""Benchmarks, exercises and training to evaluate the methods; a review does not need them."""
