"""Benchmarks, evaluation and training of networks, which are not needed to review clips."""
