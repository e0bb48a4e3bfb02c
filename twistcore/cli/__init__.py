"""The `twistcore` command: words in the parsers, one module a family of commands."""

from twistcore.cli.command_line import main

__all__ = ["main"]
