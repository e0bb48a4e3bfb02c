"""Signals, no home, a locale without letters, two at once: what a command runs among."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from inspector.session.session_files import fallback_session_path
from inspector.session.settings import Settings, load_settings, save_settings, settings_path
from tests.conftest import ASSETS
from tests.twistcore.batch_folders import COMMAND, ROOT, clips, environment
from twistcore.formats.bvh import read_bvh

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals and names as POSIX has them")

# A command that is in the midst of writing once there is a note.
WRITING = """
import sys, time
from pathlib import Path
from twistcore.files.atomic import writing_atomically
from twistcore.cli import command_line
from twistcore.work.processes import Apart

def writing(arguments):
    with writing_atomically(Path(sys.argv[1])) as file:
        file.write(b"half")
        file.flush()
        Path(sys.argv[2]).touch()
        time.sleep(600)

command_line._run = writing
sys.exit(command_line.main(["info", "x"]))
"""


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_in_the_midst_of_writing_leaves_what_was_there(tmp_path, name):
    folder, note = tmp_path / "out", tmp_path / "note"
    folder.mkdir()
    out = folder / "out.bvh"
    out.write_bytes(b"old")
    process = subprocess.Popen(
        [sys.executable, "-c", WRITING, out, note],
        cwd=ROOT, env=environment(), stderr=subprocess.PIPE, text=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    try:
        end = time.monotonic() + 60.0
        while not note.exists():
            assert time.monotonic() < end
            time.sleep(0.02)
        number = getattr(signal, name)
        process.send_signal(number)
        _, said = process.communicate(timeout=60)
    finally:
        process.kill()
    assert process.returncode == 128 + number
    assert said == "stopped\n"
    assert [path.name for path in folder.iterdir()] == ["out.bvh"]
    assert out.read_bytes() == b"old"


@pytest.mark.parametrize("older", [False, True])
def test_without_a_home_nothing_is_made_where_it_was_started(tmp_path, monkeypatch, older):
    """Whom no list of users knows has a path with a '~' in front for a home, or none at all."""
    monkeypatch.chdir(tmp_path)
    for name in ("HOME", "XDG_CONFIG_HOME", "XDG_STATE_HOME", "TWIST_INSPECTOR_SETTINGS"):
        monkeypatch.delenv(name, raising=False)

    def without_home(*_, **__):
        if not older:
            raise RuntimeError("could not determine the home directory")
        return Path("~/.config/twist-inspector")

    for name in ("user_config_path", "user_state_path"):
        monkeypatch.setattr(f"platformdirs.{name}", without_home)
    path = settings_path()
    assert path.is_absolute()
    assert fallback_session_path(tmp_path / "walk.bvh").is_absolute()
    settings, _ = load_settings(path)
    assert settings == Settings()
    assert "cannot be written" in save_settings(path, settings)
    with pytest.raises(OSError, match="Not a directory"):
        fallback_session_path(tmp_path / "walk.bvh").parent.mkdir(parents=True)
    assert list(tmp_path.iterdir()) == []


C_LOCALE = {"LC_ALL": "C", "LANG": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


@pytest.mark.thorough
def test_a_locale_without_letters_loses_no_name(tmp_path):
    """Where Python takes names for ASCII, and prints nothing else."""
    folder = tmp_path / "übung 舞"
    folder.mkdir()
    clip = folder / "wälk.bvh"
    text = (ASSETS / "walk_injected.bvh").read_bytes()
    clip.write_bytes(text.replace(b"LeftForeArm", "Unterarm é".encode()))
    out, batch = folder / "größer.bvh", folder / "aus"

    def ran(*words):
        command = [os.fsencode(word) for word in (sys.executable, "-m", "twistcore", *words)]
        done = subprocess.run(
            command, cwd=ROOT, env=environment(**C_LOCALE), capture_output=True, check=False
        )
        assert done.returncode in (0, 1), done.stderr
        assert b"Traceback" not in done.stderr
        return done.stdout

    found = json.loads(ran("detect", clip, "--json").decode())
    assert "Unterarm" in json.dumps(found)
    ran("refine", clip, "-o", out)
    assert read_bvh(out).motion.skeleton.names == read_bvh(clip).motion.skeleton.names
    ran("batch", folder, "-o", batch, "--refine", "--workers", "1")
    assert (batch / "corrected" / "wälk.bvh").exists()
    ran("report", batch, "-o", folder / "seiten")
    assert [p.name for p in (folder / "seiten").rglob("*lk*.html")]
    assert not [p.name for p in folder.rglob("*") if "?" in p.name or "\\" in p.name]


@pytest.mark.thorough
def test_of_two_runs_into_one_folder_the_second_is_told(tmp_path):
    folder, out = tmp_path / "in", tmp_path / "out"
    clips(folder, ASSETS / "walk_injected.bvh", 3, 60)
    words = [*COMMAND, str(folder), "-o", str(out), "--refine", "--workers", "1"]
    ways = {"cwd": ROOT, "env": environment(), "stdout": -1, "stderr": -1, "text": True}
    both = [subprocess.Popen(words, **ways) for _ in range(2)]
    said = [one.communicate(timeout=300)[1] for one in both]
    codes = sorted(one.returncode for one in both)
    assert codes in ([0, 0], [0, 2])
    if codes == [0, 2]:
        (printed,) = [text for one, text in zip(both, said, strict=True) if one.returncode]
        assert "another run of twistcore batch is writing to this folder" in printed
    assert sorted(p.name for p in Path(out, "corrected").iterdir()) == sorted(
        p.name for p in folder.iterdir()
    )
