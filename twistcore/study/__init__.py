"""Benchmarks, exercises and training to evaluate the methods. A review does not need them."""
