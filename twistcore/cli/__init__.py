"""The `twistcore` command, with its arguments and one module for each family of commands."""

from twistcore.cli.command_line import main

__all__ = ["main"]
