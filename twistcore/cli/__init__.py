"""The `twistcore` command: its subcommands, their arguments, and the sentences that they print."""

from twistcore.cli.command_line import main

__all__ = ["main"]
