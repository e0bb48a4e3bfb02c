"""The version of both packages. It is also read by pyproject.toml."""

__version__ = "0.3.0"
