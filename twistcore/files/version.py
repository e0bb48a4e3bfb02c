"""The version of both packages, also read by pyproject.toml."""

__version__ = "0.3.0"
