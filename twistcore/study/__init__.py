"""Benchmarks, evaluation and training of networks. Reviewing clips does not need this package."""
