"""What is built for strangers: source and wheel, installed elsewhere, with and without a window."""

import os
import pkgutil
import re
import shutil
import subprocess
import sys
import tarfile
import venv
import zipfile
from email.parser import HeaderParser
from importlib import metadata
from pathlib import Path

import pytest

import twistcore
from checkout import screens
from inspector import __main__ as words
from inspector import system_libraries
from inspector.system_libraries import has_screen
from tests.conftest import ASSETS

pytest.importorskip("build")
ROOT = Path(__file__).resolve().parents[1]
WINDOW = ("PySide6", "vtkmodules", "pyvista", "pyqtgraph", "matplotlib")
CORE_MB = 300
needs_screen = pytest.mark.skipif(
    not has_screen() and not shutil.which("Xvfb"), reason="needs a screen, or Xvfb"
)


def said_by(*command, **options) -> subprocess.CompletedProcess[str]:
    env = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}  # it may name the checkout
    return subprocess.run(
        [*map(str, command)], **{"env": env} | options, capture_output=True, text=True, timeout=120
    )


def tool(name, *words):
    done = said_by(sys.executable, "-m", name, *words, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def packages(tmp_path_factory) -> tuple[Path, Path]:
    """Source distribution, and the wheel that is built from it."""
    folder = tmp_path_factory.mktemp("dist")
    tool("build", "--no-isolation", "--outdir", folder)
    (source,), (wheel,) = folder.glob("*.tar.gz"), folder.glob("*.whl")
    return source, wheel


def about(wheel: Path):
    with zipfile.ZipFile(wheel) as files:
        (name,) = (n for n in files.namelist() if n.endswith(".dist-info/METADATA"))
        return HeaderParser().parsestr(files.read(name).decode())


def without_extras(wheel: Path) -> list[metadata.Distribution]:
    """The distributions that come with the wheel if nothing else is asked for, itself not."""
    found, todo = {}, about(wheel).get_all("Requires-Dist")
    while todo:
        requirement, _, condition = todo.pop().partition(";")
        name = re.match(r"[\w.-]+", requirement)[0]
        if "extra" not in condition and name not in found:
            found[name] = metadata.distribution(name)
            todo += found[name].requires or ()
    return [*found.values()]


def environment(folder: Path, wheel: Path) -> tuple[Path, Path]:
    """A clean environment with the wheel alone: where its commands are, and its packages."""
    venv.create(folder, with_pip=False)
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    offline = ("--no-deps", "--no-index", "--no-compile", "--quiet")
    tool("pip", "--python", python, "install", *offline, wheel)
    code = "import sysconfig; print(sysconfig.get_path('purelib'))"
    return python.parent, Path(said_by(python, "-c", code).stdout.strip())


@pytest.fixture(scope="module")
def core(packages, tmp_path_factory) -> Path:
    """Commands of an environment that has what is installed without an extra, and nothing else."""
    commands, place = environment(tmp_path_factory.mktemp("core") / "venv", packages[1])
    for distribution in without_extras(packages[1]):
        for name in {file.parts[0] for file in distribution.files} - {"..", "__pycache__"}:
            (place / name).symlink_to(distribution.locate_file(name))
    return commands


@pytest.mark.thorough
def test_an_index_would_take_both_and_show_their_text(packages):
    tool("twine", "check", "--strict", *packages)
    tool("check_wheel_contents", packages[1])
    told = about(packages[1])
    assert told["Version"] == twistcore.__version__
    assert "Project-URL" not in told, "an address that does not exist"
    text = told.get_payload()
    assert "# Twist Inspector" in text
    links = re.findall(r"""\]\(([^)]*)\)|(?:src|href)=["']([^"']*)""", text)
    assert [*filter(None, sum(links, ()))] != []
    assert [a for a in sum(links, ()) if a and not a.startswith(("https://", "http://", "#"))] == []


@pytest.mark.thorough
def test_the_source_holds_what_its_tests_need_and_nothing_that_work_leaves(packages):
    with tarfile.open(packages[0]) as files:
        names = {name.partition("/")[2] for name in files.getnames()}
    for there in ("dev.py", ".ci/run", "LICENSE", "README.md", "CHANGELOG.md", "pyproject.toml"):
        assert there in names
    for room in ("assets", "checkout", "docs", "tests", "benchmarks", "inspector", "twistcore"):
        kept = {p.relative_to(ROOT).as_posix() for p in (ROOT / room).rglob("*.[pm][yd]")}
        assert kept <= names, kept - names
    junk = re.compile(r"__pycache__|\.twist\.json|\.journal|(^|/)\.venv|_cache/|^(out|build|dist)/")
    assert [name for name in names if junk.search(name)] == []


@pytest.mark.thorough
def test_the_wheel_holds_what_the_program_shows(packages):
    with zipfile.ZipFile(packages[1]) as files:
        names = {*files.namelist()}
    assert {
        "inspector/py.typed",
        "twistcore/py.typed",
        "twistcore/skeleton/joint_names.toml",
    } <= names
    shown = {*ROOT.glob("docs/*.md"), *ROOT.glob("docs/images/*"), *ROOT.glob("assets/*.bvh")}
    shown |= {*ROOT.glob("docs/examples/*"), *ROOT.glob("docs/tables/*")}
    shown |= {*ROOT.glob("assets/icons/*"), *ROOT.glob("assets/lessons/**/*.md")}
    shown |= {*ROOT.glob("assets/languages/*")}
    for file in shown:
        place = file.relative_to(ROOT).as_posix().removeprefix("assets/")
        assert f"inspector/assets/{place}" in names
    beside = [name for name in names if name.partition("/")[0] not in ("inspector", "twistcore")]
    assert all(".dist-info/" in name for name in beside)
    assert [name for name in names if re.match(r"inspector/assets/.*\.pyc?$", name)] == []


@pytest.mark.thorough
def test_the_core_is_small(packages):
    files = [d.locate_file(f) for d in without_extras(packages[1]) for f in d.files]
    assert sum(f.stat().st_size for f in files if f.is_file()) / 1e6 < CORE_MB


@pytest.mark.thorough
def test_without_a_window_the_core_is_whole(core, packages, tmp_path):
    (tmp_path / "in").mkdir()
    clip = tmp_path / "in/walk.bvh"
    clip.write_bytes((ASSETS / "walk_injected.bvh").read_bytes())
    modules = [m.name for m in pkgutil.walk_packages(twistcore.__path__, "twistcore.")]
    assert len(modules) > 100
    left_out = "torch_model", "training"  # of the extra train
    code = [f"import {name}" for name in modules if not name.endswith((*left_out, "__main__"))]
    code += ["import sys, inspector; print(inspector.__file__)"]
    code += [f"assert not {{*{WINDOW}}} & {{*sys.modules}}"]
    done = said_by(core / "python", "-c", "\n".join(code), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert not done.stdout.startswith(str(ROOT)), "the checkout is tried, not the wheel"

    def run(*command):
        done = said_by(core / command[0], *command[1:], cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert run("twistcore", "--version") == f"twistcore {twistcore.__version__}\n"
    assert run("twist-inspector", "--version") == f"twist-inspector {twistcore.__version__}\n"
    assert "8 intervals" in run("twistcore", "detect", clip)
    run("twistcore", "batch", "in", "-o", "batch", "--refine", "--report", "--workers", "1")
    page = (tmp_path / "batch/report/clips/walk.bvh.html").read_text("utf-8")
    assert "No pictures: the window is not installed" in page


@pytest.mark.thorough
def test_a_window_that_is_not_installed_is_told_in_one_sentence(core, tmp_path):
    done = said_by(core / "twist-inspector", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    (told,) = done.stderr.splitlines()
    assert 'pip install "twist-inspector[gui]"' in told


@pytest.mark.thorough
@needs_screen
def test_the_installed_window_opens_outside_of_a_checkout(packages, tmp_path):
    commands, place = environment(tmp_path / "venv", packages[1])
    here = metadata.distribution("numpy").locate_file("")
    (place / "what-tests-run-in.pth").write_text(str(here))
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    home = {"HOME": str(elsewhere), "XDG_CONFIG_HOME": str(elsewhere)}
    with screens.screen() as env:
        program = commands / "twist-inspector"
        words = (place / "inspector/assets/walk_injected.bvh", "--screenshot", "a.png")
        env = {k: v for k, v in env.items() if k != "PYTHONPATH"} | home
        done = said_by(program, *words, cwd=elsewhere, env=env)
    assert done.returncode == 0, done.stderr
    assert (elsewhere / "a.png").stat().st_size > 50_000


# -- what the system lacks -------------------------------------------------------------------------


@pytest.fixture
def bare_system(monkeypatch):
    """A Debian on which one library of each kind is not there."""
    absent = ("libGL.so.1", "libxcb-cursor.so.0")
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("QT_QPA_PLATFORM", raising=False)
    monkeypatch.setattr(system_libraries, "is_loadable", lambda soname: soname not in absent)
    monkeypatch.setattr(system_libraries.shutil, "which", lambda _program: "/usr/bin/apt-get")


@pytest.mark.parametrize(("user", "sudo"), [(0, ""), (1000, "sudo ")])
def test_missing_libraries_end_in_the_command_that_brings_them(
    bare_system, monkeypatch, capsys, user, sudo
):
    monkeypatch.setattr(os, "geteuid", lambda: user)
    assert words.main([]) == 2
    told, command = capsys.readouterr().err.splitlines()
    assert told.startswith("twist-inspector: this system lacks libGL.so.1, libxcb-cursor.so.0.")
    install = f"{sudo}apt-get install -y --no-install-recommends libgl1 libxcb-cursor0"
    assert command == f"  {sudo}apt-get update && {install}"


def test_where_there_is_no_apt_the_packages_are_named(bare_system, monkeypatch, capsys):
    monkeypatch.setattr(system_libraries.shutil, "which", lambda _program: None)
    assert words.main([]) == 2
    (told,) = capsys.readouterr().err.splitlines()
    assert "libgl1 libxcb-cursor0" in told
    assert "apt-get" not in told


def test_off_an_x_server_its_libraries_are_not_asked_for(bare_system):
    assert [*system_libraries.missing_libraries("offscreen")] == ["libGL.so.1"]


def test_the_table_of_libraries_is_what_the_window_loads():
    """On the machine that runs the tests all are there; a name that is misspelt never is."""
    if sys.platform.startswith("linux"):
        assert system_libraries.missing_libraries() == {}


def test_words_are_read_before_anything_is_loaded():
    code = (
        "import sys\nfrom inspector.__main__ import main\n"
        "try: main(['--version'])\nexcept SystemExit: pass\n"
        "print([m for m in ('PySide6', 'numpy', 'vtkmodules') if m in sys.modules])"
    )
    done = said_by(sys.executable, "-c", code, cwd=ROOT)
    assert done.stdout == f"twist-inspector {twistcore.__version__}\n[]\n", done.stderr
