"""Programs forked off a process that has imported everything: to import takes most of a start.

From the fork on each is a process of its own, to be killed or to end as one that was started.
`forked.py SOCKET SOCKET` is what is forked off; the tests call `start`, and dev.py forks the tests.
"""

from __future__ import annotations

import array
import atexit
import contextlib
import faulthandler
import gc
import importlib
import json
import os
import runpy
import select
import signal
import socket
import subprocess
import sys
from pathlib import Path

_LARGEST = 1 << 18  # bytes of a request
_IMPORTED = ("inspector.app", "inspector.window.main_window", "PySide6.QtTest", "pytest")


class Forked:
    """A program: what tests use of `subprocess.Popen`."""

    def __init__(self, stdin, stdout, told):
        self.stdin, self.stdout, self._told = stdin, stdout, told
        line = told.readline()
        assert line, "nothing was forked"
        self.pid = int(line)
        self.returncode = None

    def poll(self):
        return self.returncode if self._ended(0) else None

    def wait(self, seconds=None):
        if not self._ended(seconds):
            raise subprocess.TimeoutExpired(str(self.pid), seconds)
        return self.returncode

    def send_signal(self, number):
        if self.poll() is None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self.pid, number)

    def terminate(self):
        self.send_signal(signal.SIGTERM)

    def kill(self):
        self.send_signal(signal.SIGKILL)

    def __exit__(self, *_):
        self.wait()
        self.close()

    def close(self):
        """Close what leads to it; it has ended."""
        for pipe in (self.stdin, self.stdout, self._told):
            if pipe:
                pipe.close()

    def __enter__(self):
        return self

    def _ended(self, seconds):
        if self.returncode is None and select.select([self._told], [], [], seconds)[0]:
            self.returncode = int(self._told.readline())
        return self.returncode is not None


class Parent:
    """The process that programs are forked off; what is forked off it asks the same one."""

    def __init__(self, python=sys.executable, environment=()):
        # Messages, not a stream: several processes ask.
        self._asked, asked = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._asked.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _LARGEST)
        root = Path(__file__).parents[2]
        ends = [asked.fileno(), self._asked.fileno()]
        with asked:
            self._process = subprocess.Popen(
                [python, __file__, *map(str, ends)],
                stdin=subprocess.PIPE,  # at its end there is nobody who asks
                stdout=subprocess.PIPE,  # a pipe, as its programs have: Python buffers by its kind
                env={**os.environ, **dict(environment), "PYTHONPATH": str(root)},
                cwd=root,
                pass_fds=ends,
            )
        self._at_exit = atexit.register(self.end)

    @classmethod
    def of(cls, asked):
        """The parent of this process, which is to be asked there."""
        own = cls.__new__(cls)
        own._asked, own._process = socket.socket(fileno=asked), None
        return own

    def start(self, words, environment, output=None, cwd=".", errors=None):
        """Run `python WORDS`, with pipes to its input and output, or all it says into a file.

        errors: subprocess.STDOUT, and they come with the output.
        """
        stdin, to_it = os.pipe()
        told, tell = os.pipe()
        if output is None:
            from_it, stdout = os.pipe()
            given, said = [stdin, stdout, stdout if errors else 2, tell], os.fdopen(from_it)
        else:
            given, said = [stdin, output.fileno(), output.fileno(), tell], None
        wanted = [[os.fspath(word) for word in words], environment, os.fspath(Path(cwd).resolve())]
        try:
            socket.send_fds(self._asked, [json.dumps(wanted).encode()], given)
        finally:
            for end in (stdin, tell, *([] if said is None else [stdout])):
                os.close(end)
        return Forked(os.fdopen(to_it, "w"), said, os.fdopen(told))

    def end(self):
        """No more programs; those that were forked off go on."""
        atexit.unregister(self._at_exit)
        self._asked.close()
        self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()  # not read to its end: programs that go on hold it, too


_parents: dict[int, Parent] = {}


def start(words, environment, parent=0, **more):
    """Run `python WORDS`, with pipes to its input and output.

    What is forked off one parent orders its sets alike; where that could matter, take two.
    """
    if parent not in _parents:
        _parents[parent] = Parent()
    return _parents[parent].start(words, environment, **more)


def run(words, environment, **more):
    """Run `python WORDS` to its end; its exit status and what it wrote to its output.

    errors: subprocess.STDOUT, and they come with the output.
    """
    with start(words, environment, **more) as process:
        said = process.stdout.read()
        return process.wait(), said


def _request(asked):
    """Words, environment, folder and pipes of the next program; None: there is none."""
    if sys.stdin in select.select([asked, sys.stdin], [], [])[0]:
        return None
    size = array.array("i").itemsize
    said, pipes, _, _ = socket.recv_fds(asked, _LARGEST, 4 * size)
    return *json.loads(said), pipes


def _keep(pid, tell):
    """Tell of a program what its parent alone hears."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.write(tell, b"%d\n" % pid)
    code = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    os.write(tell, b"%d\n" % code)
    os._exit(0)


def _become(words, environment, cwd, pipes, asked):
    for number, pipe in enumerate(pipes[:3]):
        os.dup2(pipe, number)
    for pipe in pipes:
        os.close(pipe)
    os.chdir(cwd)
    os.environ.clear()
    os.environ.update(environment)
    if environment.get("PYTHONFAULTHANDLER"):
        faulthandler.enable()
    from tests.gui import forked  # this module, as what becomes of the process imports it

    forked._parents[0] = forked.Parent.of(asked)
    if words[0] == "-m":
        sys.argv = words[1:]
        runpy.run_module(words[1], run_name="__main__", alter_sys=True)
    else:
        sys.argv = words
        runpy.run_path(words[0], run_name="__main__")


def _serve(asked, to_ask):
    """Fork until nobody asks any more; a program goes its own way, and may ask, too."""
    from inspector.unread_sources import disable_pyside_source_reading

    disable_pyside_source_reading()  # as the program does
    for module in _IMPORTED:
        importlib.import_module(module)
    gc.collect()
    gc.freeze()  # no collection looks at, and so copies, what all have in common
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # keepers are waited for by nobody
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl+C is for what was forked
    while request := _request(asked):
        pipes = request[-1]
        if os.fork() == 0:
            signal.signal(signal.SIGCHLD, signal.SIG_DFL)
            signal.signal(signal.SIGINT, signal.default_int_handler)
            asked.close()
            if pid := os.fork():
                for pipe in pipes[:3]:
                    os.close(pipe)
                _keep(pid, pipes[3])
            return _become(*request, to_ask)
        for pipe in pipes:
            os.close(pipe)
    return None


if __name__ == "__main__":
    _serve(socket.socket(fileno=int(sys.argv[1])), int(sys.argv[2]))
