"""The `twistcore` command: words in the parser, one module a family of commands."""

from twistcore.cli.parser import main

__all__ = ["main"]
