"""Fuzz: damaged files of every kind end in what they hold or in one of our sentences."""
