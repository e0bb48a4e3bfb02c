"""The `twistcore` command, with one module for each group of subcommands."""

from twistcore.cli.command_line import main

__all__ = ["main"]
