"""Children end with their parent, in the midst of what they are doing, and however it ended."""

import os
import subprocess
import sys
from multiprocessing import Pipe
from pathlib import Path

import pytest

from inspector.folder import survey_worker
from tests.processes import is_alive, until
from tests.tiers import parametrize
from tests.twistcore.batch_folders import KILL, ROOT, environment
from twistcore.errors import TwistError

pytestmark = pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="Linux")

# Each starts a child that notes its number and sleeps, and is killed meanwhile.
STARTS = {
    "a worker of a command": (
        "import functools\nfrom tests.faults.asleep import asleep\n"
        "from twistcore.work.processes import Apart\n"
        "Apart().call(asleep, {note!r}, None)"
    ),
    "a worker of the window": (
        "import multiprocessing\nfrom tests.faults import asleep\n"
        "if __name__ == '__main__':\n"
        "    process = multiprocessing.get_context('spawn').Process("
        "target=asleep.work_asleep, args=({note!r},), daemon=True)\n"
        "    process.start()\n    process.join()"
    ),
    "a module": (
        "import subprocess\nfrom twistcore.work.with_parent import parent_bound_module_command\n"
        "subprocess.run(parent_bound_module_command('tests.faults.asleep', {note!r}))"
    ),
    "another program": (
        "import subprocess, sys\nfrom twistcore.work.with_parent import parent_bound_command\n"
        "subprocess.run(parent_bound_command([sys.executable, '-m', 'tests.faults.asleep', "
        "{note!r}]),"
        " start_new_session=True)"
    ),
}


@parametrize("name", STARTS)
def test_a_child_ends_with_a_parent_that_was_killed(name, tmp_path):
    note, program = tmp_path / "pid", tmp_path / "parent.py"
    program.write_text(STARTS[name].format(note=str(note)))
    parent = subprocess.Popen([sys.executable, program], cwd=ROOT, env=environment())
    try:
        child = int(until(lambda: note.exists() and note.read_text()))
        assert child != parent.pid
        assert is_alive(child)
    finally:
        os.kill(parent.pid, KILL)
        parent.wait(60)
    until(lambda: not is_alive(child))


def test_whose_parent_was_gone_before_is_not_begun(tmp_path):
    note = tmp_path / "pid"
    program = (
        "import subprocess\nfrom twistcore.work.with_parent import parent_bound_command, "
        "parent_bound_module_command\n"
        f"for command in (parent_bound_command(['{sys.executable}', '-m', 'tests.faults.asleep', "
        f"{str(note)!r}]),"
        f" parent_bound_module_command('tests.faults.asleep', {str(note)!r})):\n"
        "    command = [w.replace(str(__import__('os').getpid()), '1000000') for w in command]\n"
        "    assert subprocess.run(command, timeout=60).returncode in (0, 1)"
    )
    subprocess.run([sys.executable, "-c", program], cwd=ROOT, env=environment(), check=True)


@pytest.mark.parametrize("found", ["a survey", TwistError("a sentence")])
def test_a_survey_that_nobody_waits_for_any_more_ends_quietly(monkeypatch, found):
    ours, theirs = Pipe()

    def surveyed(*_):
        ours.close()
        if isinstance(found, Exception):
            raise found
        return found

    monkeypatch.setattr(survey_worker, "survey_clip", surveyed)
    ours.send((Path("walk.bvh"), None))
    survey_worker.survey_clips_from_pipe(theirs)
    theirs.close()
