"""Starting, driving and killing the program as a process."""

import json
import os
import signal
from pathlib import Path

from tests.gui import forked

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


def beside(clip):
    """Names of what lies beside a clip."""
    return sorted(p.name for p in clip.parent.iterdir() if p != clip)
