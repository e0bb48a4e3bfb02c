"""The version of both packages; pyproject.toml reads it."""

__version__ = "0.3.0"
