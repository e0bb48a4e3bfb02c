"""Starting, driving and killing the program, as a process or in a window of this one."""

import json
import os
import shutil
import signal
from pathlib import Path

from tests.gui import forked
from tests.gui.driven_program import SETTINGS, Driver
from tests.gui.kept_window import KeptWindow

_DRIVER = Path(__file__).with_name("driven_program.py")


class Program:
    """`driven_program.py` with a clip; what it answered last is in `answer`."""

    def __init__(self, clip, state_home):
        environment = {**os.environ, "XDG_STATE_HOME": str(state_home)}
        self.process = forked.start([_DRIVER, clip], environment)
        self.answer = self._read()

    def tell(self, *commands):
        """Do what the commands say, one after the other; the answer to the last."""
        for command in commands:
            self.process.stdin.write(command + "\n")
            self.process.stdin.flush()
            self.answer = self._read()
        return self.answer

    def _read(self):
        line = self.process.stdout.readline()
        assert line, "the program ended without an answer"
        return json.loads(line)

    @property
    def accepted(self):
        """How many intervals are accepted."""
        return self.answer["decisions"].count("accepted")

    def kill(self):
        """kill -9."""
        self.process.send_signal(signal.SIGKILL)
        self._reap()

    def end(self):
        """The end of its input: it closes by itself."""
        self.process.stdin.close()
        self.process.wait(60)
        self._reap()

    def _reap(self):
        self.process.wait(60)
        self.process.close()


class ProgramHere:
    """The same in a window of this process, for a quarter of the processor time.

    `kept` is a list with at most one window, which is used again unless a test has closed it.
    """

    def __init__(self, clip, kept):
        if not kept:
            kept.append(KeptWindow(SETTINGS))
        self._kept, self._folder = kept, clip.parent
        self._driver = Driver(kept[0].show(), clip)
        self.answer, self._running = self._driver.answer(), True

    def tell(self, *commands):
        """Do what the commands say, one after the other; the answer to the last."""
        for command in commands:
            self.answer = self._driver.do(command)
        return self.answer

    @property
    def accepted(self):
        """How many intervals are accepted."""
        return self.answer["decisions"].count("accepted")

    def kill(self):
        """The window goes, and the files are as they were before: kill -9 would leave them so."""
        if self._running:
            places = [p for p in (self._folder, Path(os.environ["XDG_STATE_HOME"])) if p.exists()]
            left = [p.with_name(f"{p.name} as it was left") for p in places]
            for place, copy in zip(places, left, strict=True):
                shutil.copytree(place, copy, symlinks=True)
            self.end()
            for place, copy in zip(places, left, strict=True):
                shutil.rmtree(place, ignore_errors=True)
                copy.rename(place)

    def end(self):
        """The window goes."""
        if self._running:
            self._running = False
            if self._driver.window.isVisible():
                self._kept[0].put_away()
            else:
                self._kept.pop().close()


def beside(clip):
    """Names of what lies beside a clip."""
    return sorted(p.name for p in clip.parent.iterdir() if p != clip)
