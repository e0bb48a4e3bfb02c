"""The version number of twistcore and inspector. pyproject.toml reads it from this file."""

__version__ = "0.4.0"
