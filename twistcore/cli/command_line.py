"""The `twistcore` command: exit codes are a contract (0 done, 1 partly, 2 refused)."""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from twistcore.atomic import is_standard_output
from twistcore.cli.output import Voice, problem, speaking, step
from twistcore.cli.parser import make_parser
from twistcore.errors import TwistError


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns its exit code. No traceback reaches a person."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal without θ or → is no reason to fail
    arguments = make_parser().parse_args(argv)
    document = getattr(arguments, "json", None) is True
    voice = Voice(arguments.quiet, arguments.verbose, document)
    try:
        with speaking(voice), step(arguments.command):
            code = _run(arguments)
        sys.stdout.flush()  # a reader that has gone is noticed here, not at the interpreter's end
    except TwistError as error:
        problem(" ".join(str(error).splitlines()))
        return 2
    except BrokenPipeError:  # the reader of a pipe has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        problem(f"{error.filename or 'file'}: {error.strerror}")
        return 2
    except KeyboardInterrupt:
        problem("stopped")
        return 130
    return code


def _run(arguments: argparse.Namespace) -> int:
    """The command; where an output is standard output, what is said goes to standard error."""
    if not any(is_standard_output(v) for v in vars(arguments).values() if isinstance(v, Path)):
        return int(arguments.run(arguments))
    if getattr(arguments, "json", None) is True:
        raise TwistError("--json: expected nothing else on standard output")
    with contextlib.redirect_stdout(sys.stderr):
        return int(arguments.run(arguments))
