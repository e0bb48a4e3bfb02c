"""Run `twistcore completion`, which prints a shell script that completes commands and options.

shtab creates the script from the parser, so the shell need not start Python when Tab is pressed.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from twistcore.cli.arguments import argument_types
from twistcore.cli.parser import command_parsers, make_parser
from twistcore.errors import TwistError

_FILES = (
    Path,
    argument_types.parse_output_path,
    argument_types.parse_clip_output_path,
    argument_types.parse_clip_input_path,
)


def completion_command(arguments: argparse.Namespace) -> int:
    """Print the script and return the exit code. Raises TwistError if shtab is not installed."""
    try:
        import shtab
    except ImportError:
        raise TwistError("completion requires the package shtab: pip install shtab") from None
    parser = make_parser()
    for _, leaf in command_parsers(parser):
        for action in leaf._actions:
            if action.type in _FILES:
                action.complete = shtab.FILE  # type: ignore[attr-defined]
            elif action.type is argument_types.parse_output_folder:
                action.complete = shtab.DIRECTORY  # type: ignore[attr-defined]
    print(shtab.complete(parser, arguments.shell))
    return 0
