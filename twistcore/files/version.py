"""The version of both packages, which pyproject.toml reads."""

__version__ = "0.3.0"
