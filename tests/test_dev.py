"""dev.py: what it does when something is missing, and that it leaves nothing running."""

import contextlib
import importlib.util
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
from pathlib import Path

import pytest

import dev
from checkout import all_tests, environment, places, screens, starting, system_packages
from inspector import system_libraries
from tests.gui import forked

needs_xvfb = pytest.mark.skipif(
    not sys.platform.startswith("linux") or not shutil.which("Xvfb"), reason="needs Xvfb"
)


@pytest.fixture
def no_screen(monkeypatch):
    """A machine without a display."""
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)


@pytest.fixture
def bare_project(tmp_path, monkeypatch):
    """An empty checkout; the interpreter of its .venv is the one that runs the test."""
    (tmp_path / "pyproject.toml").write_text("[project]")
    (tmp_path / ".venv").mkdir()
    monkeypatch.setattr(places, "ROOT", tmp_path)
    monkeypatch.setattr(places, "VENV", tmp_path / ".venv")
    monkeypatch.setattr(places, "STAMP", tmp_path / ".venv/stamp")
    monkeypatch.setattr(places, "PYTHON", Path(sys.executable))
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # pytest starts in half the time
    return tmp_path


def gone(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


def screen_answers(display: str) -> bool:
    """Whether an X server listens there. Xvfb keeps no lock file once it chose its own number."""
    with socket.socket(socket.AF_UNIX) as client:
        return client.connect_ex(f"/tmp/.X11-unix/X{display.removeprefix(':')}") == 0


def test_an_old_python_is_told_in_one_sentence(monkeypatch, capsys):
    monkeypatch.setattr(sys, "version_info", (3, 9, 2))
    assert dev.main(["run"]) == 2
    assert "needs Python 3.11" in capsys.readouterr().out


def test_an_unknown_command_names_the_known(capsys):
    assert dev.main(["rnu"]) == 2
    assert "run, test, check" in capsys.readouterr().out


def test_missing_libraries_name_their_packages(monkeypatch, no_screen):
    monkeypatch.setattr(system_libraries, "is_loadable", lambda soname: "xcb-cursor" not in soname)
    monkeypatch.setattr(shutil, "which", lambda _program: None)
    monkeypatch.delenv("CI", raising=False)
    packages = set(system_packages.missing_system(windows=True).values())
    assert packages == {"libxcb-cursor0", "xvfb", "libgl1-mesa-dri"}
    assert not system_packages.missing_system(windows=False)
    for_tests = set(system_packages.missing_system(windows=True, tests=True).values())
    assert for_tests == packages | {"openbox", "xcompmgr", "xdotool"}
    monkeypatch.setenv("CI", "true")
    in_ci = set(system_packages.missing_system(windows=True, tests=True).values())
    assert in_ci == for_tests | {"chromium"}


def test_programs_for_tests_are_looked_for_beside_a_real_screen(monkeypatch, no_screen):
    monkeypatch.setenv("DISPLAY", ":77")
    monkeypatch.delenv("CI", raising=False)
    monkeypatch.setattr(system_libraries, "is_loadable", lambda _soname: True)
    monkeypatch.setattr(shutil, "which", lambda program: program == "openbox")
    packages = set(system_packages.missing_system(windows=True, tests=True).values())
    assert packages == {"xvfb", "libgl1-mesa-dri", "xcompmgr", "xdotool"}
    assert not system_packages.missing_system(windows=True)


def test_a_python_without_venv_is_completed(monkeypatch, no_screen, bare_project):
    monkeypatch.setattr(places, "PYTHON", bare_project / "no-python")
    monkeypatch.setattr(shutil, "which", lambda _program: None)
    monkeypatch.setattr(importlib.util, "find_spec", lambda _module: None)
    (package,) = system_packages.missing_system(windows=False).values()
    assert package.endswith("-venv")
    assert package in system_packages.missing_system(windows=True).values()


def test_without_root_the_one_command_is_printed(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda _program: "apt-get")
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    with pytest.raises(starting.SetupError, match=r"sudo apt-get install .* libgl1 xvfb"):
        system_packages.install_packages(["libgl1", "xvfb"])


def test_without_apt_the_packages_are_named(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda _program: None)
    with pytest.raises(starting.SetupError, match="libxcb-cursor0"):
        system_packages.install_packages(["libxcb-cursor0"])


def test_a_failed_installation_is_told_with_its_last_lines(bare_project, monkeypatch, capsys):
    monkeypatch.setattr(dev, "ensure_system", lambda **_: None)
    monkeypatch.setattr(shutil, "which", lambda _program: None)
    monkeypatch.setattr(environment, "quietly", lambda *_: "  ERROR: no route to host")
    assert dev.main(["setup"]) == 2
    told = capsys.readouterr().out
    assert "offline?" in told
    assert told.endswith("ERROR: no route to host\n")
    assert not places.STAMP.exists()


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ("SSLError(1, '[SSL: CERTIFICATE_VERIFY_FAILED] self-signed certificate')", "PIP_CERT"),
        ("NewConnectionError: Failed to establish a new connection", "offline?"),
        ("ERROR: OSError: [Errno 28] No space left on device", "no space"),
        ("ERROR: No matching distribution found for numpy>=9", "--unlocked"),
        ("ERROR: the compiler failed", "could not be installed.\n"),
    ],
)
def test_why_pip_failed_is_told_and_not_guessed(bare_project, monkeypatch, capsys, said, told):
    """pip ends with ERROR: lines that name a package; the cause stands before, as a warning."""
    lines = [f"Could not fetch URL: {said}", "Looking elsewhere", "ERROR: No version of numpy"]
    code = f"import sys; print(*{lines!r}, sep='\\n'); sys.exit(1)"
    wrong = starting.quietly([sys.executable, "-c", code])
    assert wrong.splitlines()[-1] == "  ERROR: No version of numpy"
    monkeypatch.setattr(environment, "quietly", lambda *_: wrong if "ERROR" not in said else said)
    with pytest.raises(starting.SetupError) as error:
        environment.install_project(None)
    assert told in str(error.value)
    assert said in str(error.value)
    assert "offline?" in told or "offline?" not in str(error.value)


def test_a_disk_that_is_too_full_is_told_before_anything_is_installed(
    bare_project, monkeypatch, capsys
):
    monkeypatch.setattr(dev, "ensure_system", lambda **_: None)
    monkeypatch.setattr(places, "PYTHON", bare_project / "no-python")
    monkeypatch.setattr(environment, "make_venv", lambda _uv: pytest.fail("begun"))
    room = shutil.disk_usage(bare_project)._replace(free=int(0.7e9))
    monkeypatch.setattr(shutil, "disk_usage", lambda _folder: room)
    assert dev.main(["setup"]) == 2
    (told,) = capsys.readouterr().out.splitlines()
    assert f"{environment.SETUP_GB:g} GB" in told
    assert "0.7 GB are free" in told


@pytest.mark.parametrize("disk", ["the cache", "temporary files", "half an environment"])
def test_every_disk_that_is_too_full_is_told(disk, bare_project, monkeypatch):
    """A bare machine may have small disks for its home and for temporary files."""
    small, usage = bare_project / "small", shutil.disk_usage(bare_project)
    small.mkdir()
    monkeypatch.setenv("UV_CACHE_DIR", str(small if disk == "the cache" else bare_project))
    temporary = small if disk == "temporary files" else bare_project
    monkeypatch.setattr(tempfile, "gettempdir", lambda: str(temporary))
    monkeypatch.setattr(environment, "disk_of", lambda folder: int(folder == small))
    full = {"half an environment": bare_project}.get(disk, small)

    def room(where):
        return usage._replace(free=int(0.2e9 if where == full else 9e9))

    monkeypatch.setattr(shutil, "disk_usage", room)
    with pytest.raises(starting.SetupError, match=r"0\.2 GB are free") as error:
        environment.ensure_room()
    assert str(full) in str(error.value)
    full = None
    environment.ensure_room()


def test_an_environment_that_is_there_needs_little_room(bare_project, monkeypatch):
    room = shutil.disk_usage(bare_project)._replace(free=int(0.7e9))
    monkeypatch.setattr(shutil, "disk_usage", lambda _folder: room)
    with (bare_project / ".venv/large").open("wb") as file:
        file.truncate(int(0.5e9))
    with pytest.raises(starting.SetupError, match="free"):
        environment.ensure_room()
    with (bare_project / ".venv/large").open("wb") as file:
        file.truncate(int(1.9e9))
    environment.ensure_room()


def test_a_long_installation_shows_how_far_it_is(bare_project, monkeypatch, capsys):
    room = shutil.disk_usage(bare_project)
    free = iter([int(5e9), *[int(4.2e9)] * 1000])
    monkeypatch.setattr(shutil, "disk_usage", lambda _folder: room._replace(free=next(free)))
    with environment.showing_progress(every_s=0.01):
        time.sleep(0.2)
    assert "0.8 GB written" in capsys.readouterr().out
    time.sleep(0.1)
    assert not capsys.readouterr().out


def test_setup_takes_unlocked_and_no_other_word(bare_project, monkeypatch, capsys):
    given = []
    monkeypatch.setattr(dev, "ensure_system", lambda **_: None)
    monkeypatch.setattr(dev, "ensure_venv", lambda **words: given.append(words["unlocked"]))
    assert dev.main(["setup", "--unlocked"]) == dev.main(["setup"]) == 0
    assert given == [True, False]
    assert dev.main(["setup", "--unlockd"]) == 2
    assert "--unlockd" in capsys.readouterr().out


def test_setup_repeats_only_when_the_project_changed(bare_project, monkeypatch):
    installed = []
    monkeypatch.setattr(environment, "install_project", lambda uv, **_: installed.append(uv))
    environment.ensure_venv()
    environment.ensure_venv()
    assert len(installed) == 1
    (bare_project / "pyproject.toml").write_text("[project] # changed")
    environment.ensure_venv()
    assert len(installed) == 2


def test_a_working_venv_is_adopted_and_a_broken_one_made_again(bare_project, monkeypatch):
    made = []
    monkeypatch.setattr(environment, "make_venv", made.append)
    monkeypatch.setattr(environment, "install_project", lambda _uv, **_: None)
    environment.ensure_venv()
    assert not made
    monkeypatch.setattr(places, "PYTHON", bare_project / "no-python")
    environment.ensure_venv()
    assert len(made) == 1


def test_quietly_returns_what_says_why():
    code = "import sys; [print('line', n) for n in range(9)]; sys.exit(3)"
    assert starting.quietly([sys.executable, "-c", "print('fine')"]) == ""
    assert starting.quietly([sys.executable, "-c", code]).splitlines()[-1] == "  line 8"
    code = "import sys; print('ERROR: no such version'); print(' note: see above'); sys.exit(1)"
    assert starting.quietly([sys.executable, "-c", code]) == "  ERROR: no such version"
    assert "no-such-program" in starting.quietly(["no-such-program"])


def test_start_passes_the_exit_status_on():
    exits = [sys.executable, "-c", "import sys; sys.exit(5)"]
    killed = [sys.executable, "-c", "import os; os.kill(os.getpid(), 15)"]
    assert starting.start(exits, dict(os.environ)) == 5
    assert starting.start(killed, dict(os.environ)) == 128 + signal.SIGTERM


def test_what_drivers_say_of_a_virtual_screen_is_left_out(capfd):
    noise = ["libGL error: failed to load driver: swrast", "MESA: error: ZINK: no pdev"]
    kept = ["twist-inspector: a.bvh: there is no such file.", "Traceback: GL was not found"]
    code = f"import sys; print(*{noise + kept!r}, sep='\\n', file=sys.stderr); print('out')"
    with starting.without_driver_noise() as errors:
        assert starting.start([sys.executable, "-c", code], dict(os.environ), errors=errors) == 0
    out, said = capfd.readouterr()
    assert said.splitlines() == kept
    assert out == "out\n"


@pytest.mark.thorough
def test_all_tests_run_in_parts_and_a_part_that_dies_is_run_again_once(
    bare_project, monkeypatch, capsys
):
    monkeypatch.setattr(all_tests, "screen", lambda: contextlib.nullcontext(dict(os.environ)))
    monkeypatch.setattr(dev, "warn_of_missing_translations", lambda: 0)
    gui = bare_project / "tests/gui"
    gui.mkdir(parents=True)
    thorough = "\n@pytest.mark.thorough\ndef test_dear(): pass\n"
    core = f"import pytest\ndef test_core(): pass\n{thorough}"
    (bare_project / "tests/test_core.py").write_text(core)
    marks = "[tool.pytest.ini_options]\nmarkers = ['thorough: dear']\n"
    (bare_project / "pyproject.toml").write_text(marks)
    (gui / "test_sound.py").write_text("def test_a(): pass\n")
    falls_once = "import os, pathlib\ndef test_b():\n    mark = pathlib.Path('fell')\n"
    falls_once += "    if not mark.exists(): mark.touch(); os.abort()\n"
    (gui / "test_falls.py").write_text(falls_once)
    monkeypatch.chdir(bare_project)
    assert dev.command_test([]) == 0
    told = capsys.readouterr().out.splitlines()
    assert "python3 dev.py test --all" in told[1]
    assert told[-1] == "3 passed, 0 failed, 0 skipped"
    assert "tests/gui/test_falls.py" in told[-2]
    monkeypatch.setattr(all_tests, "parent_of_tests", contextlib.nullcontext)  # as where none forks
    assert dev.command_test(["--all"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "4 passed, 0 failed, 0 skipped"

    (gui / "test_falls.py").write_text("import os\ndef test_b(): os.abort()\n")
    (gui / "test_wrong.py").write_text(
        "def test_c():\n    assert not 'c',\\\n        'why\\nmore'\n"
    )
    (gui / "test_broken.py").write_text("import no_such_module\n")
    (gui / "test_dear.py").write_text(f"import pytest\n{thorough}")
    assert dev.command_test([]) == 1
    told = capsys.readouterr().out.splitlines()
    assert told[-1] == "2 passed, 3 failed, 0 skipped"
    assert sorted(told[told.index("Failed:") + 1 : -1]) == [
        "  tests/gui/test_broken.py: ModuleNotFoundError: No module named 'no_such_module'",
        "  tests/gui/test_falls.py: its process crashed.",
        "  tests/gui/test_wrong.py::test_c: AssertionError: why",
    ]

    late = "def pytest_sessionfinish(session): session.exitstatus = 1\n"
    (bare_project / "tests/conftest.py").write_text(late)
    done = all_tests.run_part(["tests/test_core.py"])
    assert done.counts == {"passed": 2, "failed": 1, "skipped": 0}
    assert "outside of any test" in done.failures[0]
    (bare_project / "tests/conftest.py").unlink()
    (bare_project / "tests/test_core.py").write_text("def test_d(): raise KeyboardInterrupt\n")
    with pytest.raises(KeyboardInterrupt):
        all_tests.run_part(["tests/test_core.py"])


@pytest.mark.thorough
def test_a_failure_is_listed_with_the_first_line_of_its_reason(bare_project, monkeypatch):
    monkeypatch.setattr(all_tests, "screen", lambda: contextlib.nullcontext(dict(os.environ)))
    text = """
        import pytest
        class TestAll:
            @pytest.mark.parametrize("x", [1, 2.5])
            def test_one(self, x): assert x == 1, "no\\nmore"
        @pytest.fixture
        def gone(): raise OSError("a.b is gone")
        def test_two(gone): pass
        @pytest.mark.skip
        def test_three(): pass
    """
    (bare_project / "test_a.py").write_text(textwrap.dedent(text))
    done = all_tests.run_part(["test_a.py"])
    assert done.counts == {"passed": 1, "failed": 2, "skipped": 1}
    assert all_tests.failure_lines(done.failures)[1:] == [
        "Failed:",
        "  test_a.py::TestAll::test_one[2.5]: AssertionError: no",
        '  test_a.py::test_two: failed on setup with "OSError: a.b is gone"',
    ]
    assert all_tests.failure_lines([]) == []
    assert all_tests.run_part(["test_a.py", "-k", "nothing"]).counts == {}


class Forked:
    """A program of which nothing is heard any more."""

    def __init__(self, pid):
        self.pid = pid

    def wait(self):
        return int("")

    def close(self):
        self.wait = self.terminate = None


@pytest.mark.thorough
def test_tests_run_although_what_they_are_forked_off_is_gone(bare_project, monkeypatch):
    monkeypatch.setattr(all_tests, "screen", lambda: contextlib.nullcontext(dict(os.environ)))
    (bare_project / "test_a.py").write_text("def test_a(): pass\n")

    class Parent:
        def start(self, *_):
            raise self.gone

    parent, passed = Parent(), all_tests.Outcome({"passed": 1, "failed": 0, "skipped": 0})
    with (bare_project / "said").open("w+b") as output:
        for parent.gone in (BrokenPipeError(), AssertionError("nothing was forked")):
            assert all_tests.run_part(["test_a.py"], output, parent) == passed
        with subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"]) as lost:
            parent.start = lambda *_: Forked(lost.pid)
            assert all_tests.run_part(["test_a.py"], output, parent) == passed
            assert lost.wait(20) == -signal.SIGKILL
    assert not starting.RUNNING


@pytest.mark.thorough
def test_a_program_that_is_left_over_does_not_keep_the_run_from_ending(tmp_path):
    script = tmp_path / "stays.py"
    script.write_text("import time\ntime.sleep(600)\n")
    parent = forked.Parent()
    program = parent.start([script], dict(os.environ))
    ended = threading.Thread(target=parent.end, daemon=True)
    try:
        ended.start()
        ended.join(60)
        assert not ended.is_alive()
        assert program.poll() is None
    finally:
        program.kill()
        program.wait()
        program.close()
        ended.join()


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["-k", "chain"], ["-m", "not thorough", "-k", "chain"]),
        (["-x", "--maxfail=2"], ["-m", "not thorough", "-x", "--maxfail=2"]),
        (["--all", "-k", "chain"], ["-k", "chain"]),
        (["-m", "thorough"], ["-m", "thorough"]),
        (["tests/test_dev.py::test_x"], ["tests/test_dev.py::test_x"]),
    ],
)
def test_thorough_tests_are_run_where_a_file_or_a_mark_is_named(monkeypatch, args, words):
    started = []
    monkeypatch.chdir(places.ROOT)
    monkeypatch.setattr(dev, "screen", lambda: contextlib.nullcontext({}))
    monkeypatch.setattr(dev, "start", lambda command, env: started.append((command[3:], env)) or 0)
    assert dev.command_test(args) == 0
    examples = "patient" if "--all" in args else "quick"
    assert started == [(words, {"TWIST_INSPECTOR_EXAMPLES": examples})]


@pytest.mark.parametrize(("ci", "status"), [("", 0), ("true", 1)])
def test_a_missing_translation_fails_the_check_in_ci_only(monkeypatch, ci, status):
    monkeypatch.setenv("CI", ci)
    lacking = ["-m", "tests.gui.untranslated"]
    monkeypatch.setattr(dev, "start", lambda command, _: int(command[1:] == lacking))
    assert dev.command_check([]) == status


def test_modules_that_take_long_come_first():
    modules = all_tests.window_tests()
    assert len(modules) == len(set(modules)) == len([*places.ROOT.glob("tests/gui/test_*.py")])
    long = [any(name in module for name in all_tests.LONG) for module in modules]
    assert long == sorted(long, reverse=True)
    gone = [name for name in all_tests.LONG if not any(name in module for module in modules)]
    assert gone == [], "or renamed"


def test_no_process_starts_for_a_module_without_quick_tests(monkeypatch, tmp_path):
    monkeypatch.setattr(places, "ROOT", tmp_path)
    mark = "pytest.mark.thorough"
    texts = {
        "one": f"import pytest\n\npytestmark = {mark}\n",
        "several": f"pytestmark = [\n    {mark},\n    pytest.mark.skip,\n]\n",
        "tests": f"@{mark}\ndef test_a(): pass\ndef test_b(): pass\n",
        "other": f"pytestmark = pytest.mark.skip\n@{mark}\ndef test_a(): pass\n",
    }
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    assert [name for name in texts if all_tests.has_quick(name)] == ["tests", "other"]


def test_every_module_is_in_one_part():
    core = [module for part in all_tests.core_tests() for module in part]
    assert len(core) == len(set(core))
    every = {
        path.relative_to(places.ROOT).as_posix() for path in places.ROOT.glob("tests/**/test_*.py")
    }
    assert every == {*core, *all_tests.window_tests()}


@pytest.mark.parametrize("tier", [all_tests.QUICK, all_tests.ALL], ids=["quick", "all"])
def test_short_modules_share_a_process(tier):
    parts = all_tests.window_parts(tier)
    modules = [module for part in parts for module in part]
    wanted = all_tests.window_tests()
    if tier is all_tests.QUICK:
        wanted = [module for module in wanted if all_tests.has_quick(module)]
    assert sorted(modules) == sorted(wanted)
    shared = [part for part in parts if len(part) > 1]
    assert len(shared) >= 5
    assert max(map(len, shared)) == tier.group
    assert not any(name in module for part in shared for module in part for name in tier.alone)


def test_the_default_clip_is_the_one_with_a_truth(tmp_path, monkeypatch):
    monkeypatch.setattr(places, "ROOT", tmp_path)
    (tmp_path / "assets").mkdir()
    with pytest.raises(starting.SetupError, match="Name a BVH file"):
        dev.default_clip()
    (tmp_path / "assets/dance.bvh").touch()
    (tmp_path / "assets/run_injected.bvh").touch()
    (tmp_path / "assets/run_injected.truth.json").touch()
    assert dev.default_clip().name == "run_injected.bvh"
    (tmp_path / "assets/walk_injected.bvh").touch()
    assert dev.default_clip().name == "walk_injected.bvh"


def test_the_sample_is_opened_as_a_copy_so_that_nothing_is_written_next_to_it(
    tmp_path, monkeypatch
):
    commands = []
    monkeypatch.setattr(places, "OUT", tmp_path / "out")
    monkeypatch.setattr(dev, "has_screen", lambda: True)
    monkeypatch.setattr(dev, "start", lambda command, *_: commands.append(command[3:]) or 0)
    monkeypatch.setattr(dev, "screen", lambda: contextlib.nullcontext({}))
    copy = tmp_path / "out" / dev.default_clip().name
    for _ in range(2):  # the second time, the copy is there
        assert dev.command_run([]) == 0
    assert dev.command_run(["mine.bvh"]) == 0
    assert commands == [[str(copy)], [str(copy)], ["mine.bvh"]]
    assert copy.read_bytes() == dev.default_clip().read_bytes()


@pytest.fixture
def started(tmp_path, monkeypatch, no_screen):
    """The commands that are started on a virtual screen; the program leaves a report."""
    commands = []

    def start(command, env, cwd, **_):
        commands.append(command[1:])
        for name in ("inspector.png", "report/index.html", "report/film.xyz"):
            (places.OUT / name).parent.mkdir(parents=True, exist_ok=True)
            (places.OUT / name).touch()
        return 0

    monkeypatch.setattr(places, "OUT", tmp_path / "out")
    monkeypatch.setattr(dev, "start", start)
    monkeypatch.setattr(dev, "screen", lambda: contextlib.nullcontext({}))
    return commands


def test_without_a_screen_the_sample_is_demonstrated_and_all_that_is_left_is_told(started, capsys):
    assert dev.command_run([]) == 0
    assert started == [["-m", "inspector", str(dev.default_clip()), "--demo", str(places.OUT)]]
    told = capsys.readouterr().out
    assert "demonstration" in told
    assert "inspector.png" in told
    assert "report/index.html" in told
    assert "report/film.xyz" in told, "a kind of file that is not known"


@pytest.mark.parametrize("name", ["mine.bvh", "mine.twist.json", "folder"])
def test_without_a_screen_nothing_is_decided_of_a_clip_that_is_named(started, capsys, name):
    assert dev.command_run([name]) == 0
    picture = ["-m", "inspector", name, "--screenshot", str(places.OUT / "inspector.png")]
    findings = ["-m", "twistcore", "detect", name]
    assert started == ([picture, findings] if name == "mine.bvh" else [picture])
    told = capsys.readouterr().out
    assert "Nothing is decided" in told
    assert "demonstration" not in told


def test_a_real_screen_is_used_as_it_is(monkeypatch):
    monkeypatch.setenv("DISPLAY", ":77")
    with screens.screen() as env:
        assert env["DISPLAY"] == ":77"


@needs_xvfb
def test_the_virtual_screen_is_put_away_also_after_ctrl_c(no_screen):
    with contextlib.suppress(KeyboardInterrupt), screens.screen() as env:
        assert env["QT_QPA_PLATFORM"] == "xcb"
        assert screen_answers(env["DISPLAY"])
        raise KeyboardInterrupt
    assert not screen_answers(env["DISPLAY"])


@needs_xvfb
def test_a_screen_that_does_not_start_is_told(no_screen, monkeypatch, tmp_path):
    fake = tmp_path / "Xvfb"
    fake.write_text("#!/bin/sh\nexit 1\n")
    fake.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    with pytest.raises(starting.SetupError, match="did not start"), screens.screen():
        pass


@needs_xvfb
def test_ending_dev_py_ends_program_and_screen(no_screen, tmp_path):
    code = (
        "import signal, sys\nfrom checkout import screens, starting\n"
        "signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))\n"
        "tell = 'import os, time; print(os.getpid(), os.environ[\"DISPLAY\"], flush=True);'\n"
        "with screens.screen() as env:\n"
        "    starting.start([sys.executable, '-c', tell + 'time.sleep(60)'], env)\n"
    )
    env = {name: value for name, value in os.environ.items() if "DISPLAY" not in name}
    with subprocess.Popen(
        [sys.executable, "-c", code], env=env, cwd=places.ROOT, stdout=subprocess.PIPE, text=True
    ) as process:
        program, display = process.stdout.readline().split()
        answered = screen_answers(display)
        process.send_signal(signal.SIGTERM)
        assert process.wait(20) == 143
    assert answered
    assert gone(int(program))
    assert not screen_answers(display)
