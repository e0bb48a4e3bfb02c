"""Run the `twistcore` command. The exit codes are 0 (done), 1 (partly done) and 2 (refused)."""

from __future__ import annotations

import argparse
import contextlib
import gc
import io
import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path

from twistcore.cli.output import Voice, print_problem, print_step_duration, use_output_voice
from twistcore.cli.parser import make_parser
from twistcore.errors import TwistError
from twistcore.files.atomic import is_standard_output


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command and return its exit code. An error is printed in one line without a traceback.

    `argv` are the arguments. By default, the arguments of this process are used, and the process is
    assumed to end after the command.
    """
    if argv is not None:
        return _main(argv)
    gc.disable()  # loading modules produces hardly any garbage; `deferred` enables collection
    try:
        return _main(sys.argv[1:], alone=True)
    finally:
        gc.freeze()  # saves a last collection, since the process is about to end


def _main(argv: Sequence[str], *, alone: bool = False) -> int:
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal may lack characters such as θ or →
    arguments = make_parser(argv).parse_args(argv)
    arguments.alone = alone  # in a process that runs only this command
    document = getattr(arguments, "json", None) is True
    voice = Voice(arguments.quiet, arguments.verbose, document)
    try:
        with (
            _ended_by_signals(),
            use_output_voice(voice),
            print_step_duration(arguments.command),
            _detector(arguments),
        ):
            code = _run(arguments)
        sys.stdout.flush()  # so that a closed pipe is reported here
    except TwistError as error:
        print_problem(" ".join(str(error).splitlines()))
        return 2
    except BrokenPipeError:  # the reader of the pipe has closed it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        print_problem(f"{error.filename or 'file'}: {error.strerror}")
        return 2
    except KeyboardInterrupt as error:
        print_problem("stopped")
        return 128 + (error.number if isinstance(error, _EndedError) else signal.SIGINT)
    return code


@contextlib.contextmanager
def _detector(arguments: argparse.Namespace) -> Iterator[None]:
    """Register the detector given by --detector, also for processes that the command starts."""
    place = getattr(arguments, "detector", None)
    if place is None:
        yield
        return
    from twistcore.detection.registry import register_detector_file

    with register_detector_file(place) as arguments.method:
        yield


class _EndedError(KeyboardInterrupt):
    """Raised when a signal ends the program, for example because its terminal was closed."""

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


@contextlib.contextmanager
def _ended_by_signals() -> Iterator[None]:
    """Raise _EndedError on SIGTERM and SIGHUP, so that files are cleaned up.

    A signal that already has a handler is not affected. A second signal ends the process
    immediately.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def end(number: int, _frame: object) -> None:
        signal.signal(number, signal.SIG_DFL)
        raise _EndedError(number)

    numbers = (signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM))
    handled = [n for n in dict.fromkeys(numbers) if signal.getsignal(n) == signal.SIG_DFL]
    for number in handled:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number in handled:
            signal.signal(number, signal.SIG_DFL)


def _run(arguments: argparse.Namespace) -> int:
    """Run the command. If its output file is standard output, print messages on standard error."""
    if not any(is_standard_output(v) for v in vars(arguments).values() if isinstance(v, Path)):
        return int(arguments.run(arguments))
    if getattr(arguments, "json", None) is True:
        raise TwistError("--json writes to standard output; write the other output to a file")
    with contextlib.redirect_stdout(sys.stderr):
        return int(arguments.run(arguments))
