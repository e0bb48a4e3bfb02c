"""Where what we install and ship comes from: lock files, hashes, licences."""

from __future__ import annotations

import csv
import io
import itertools
import re
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import build_bundle
import list_licences
import pytest

from checkout import environment, places, starting

pytest.importorskip("packaging.requirements")
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[1]
# What a marker asks of the systems and Pythons that the lock files are for.
SYSTEMS = [
    {"sys_platform": "linux", "platform_system": "Linux", "os_name": "posix"},
    {"sys_platform": "darwin", "platform_system": "Darwin", "os_name": "posix"},
    {"sys_platform": "win32", "platform_system": "Windows", "os_name": "nt"},
]
PYTHONS = ["3.11", "3.12", "3.13", "3.14"]


def environments() -> list[dict[str, str]]:
    common = {"implementation_name": "cpython", "platform_python_implementation": "CPython"}
    pairs = itertools.product(SYSTEMS, PYTHONS)
    return [
        common | s | {"python_version": p, "python_full_version": f"{p}.9", "extra": ""}
        for s, p in pairs
    ]


def locked(file: Path) -> list[tuple[Requirement, list[str]]]:
    """What a lock file pins, and the hashes of each."""
    entries = re.split(r"\n(?=[^\s#])", file.read_text("utf-8"))[1:]
    lines = [entry.replace("\\\n", " ").split("--hash=") for entry in entries]
    return [(Requirement(words[0]), [w.strip() for w in words[1:]]) for words in lines]


def asked_for(extra: str) -> list[Requirement]:
    """What pyproject.toml asks for with an extra, the extras that it names included."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    found, todo = [], [*project["dependencies"], *project["optional-dependencies"][extra]]
    while todo:
        requirement = Requirement(todo.pop())
        if requirement.name != "twist-inspector":
            found.append(requirement)
        for name in requirement.extras if requirement.name == "twist-inspector" else ():
            todo += project["optional-dependencies"][name]
    return found


@pytest.mark.parametrize(("file", "extra"), environment.LOCKED_EXTRAS.items())
def test_lock_files_hold_all_that_is_asked_for_within_its_bounds(file, extra):
    pins = [pin for pin, _ in locked(file)]
    assert len(pins) > 60
    for place in environments():
        here = [p for p in pins if p.marker is None or p.marker.evaluate(place)]
        versions = {p.name: next(iter(p.specifier)).version for p in here}
        assert len(versions) == len(here), "two versions of one package"
        for wanted in asked_for(extra):
            name = canonicalize_name(wanted.name)
            if wanted.marker is None or wanted.marker.evaluate(place):
                told = f"{wanted}: python3 dev.py lock"
                assert versions.get(name) in wanted.specifier, told


@pytest.mark.parametrize("file", environment.LOCKED_EXTRAS)
def test_lock_files_name_versions_and_hashes_and_no_place(file):
    for pin, hashes in locked(file):
        assert [s.operator for s in pin.specifier] == ["=="]
        assert pin.url is None
        assert hashes
        assert all(re.fullmatch(r"sha256:[0-9a-f]{64}", digest) for digest in hashes)
    assert "://" not in file.read_text("utf-8")
    assert "index-url" not in file.read_text("utf-8")


def test_a_bundle_is_made_of_the_versions_that_are_tested():
    tested = {(p.name, str(p.specifier)): h for p, h in locked(places.LOCK)}
    bundled = {(p.name, str(p.specifier)): h for p, h in locked(places.BUNDLE_LOCK)}
    assert {p: h for p, h in bundled.items() if p in tested} == {
        p: h for p, h in tested.items() if p in bundled
    }
    names = {name for name, _ in tested}
    assert {name for (name, v) in bundled if name in names and (name, v) not in tested} == set()


# -- what a package index may do -------------------------------------------------------------------


@pytest.fixture
def index(tmp_path):
    """A folder with one package, as pip finds it; a requirement of it with a wrong hash."""
    (tmp_path / "src").mkdir()
    (tmp_path / "src/pyproject.toml").write_text(
        '[build-system]\nrequires = ["hatchling"]\nbuild-backend = "hatchling.build"\n'
        '[project]\nname = "tampered"\nversion = "1.0"\n'
    )
    (tmp_path / "src/tampered.py").touch()
    pytest.importorskip("build")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir"]
    subprocess.run([*build, tmp_path / "wheels", tmp_path / "src"], check=True, capture_output=True)
    return tmp_path / "wheels"


def test_what_is_not_as_locked_is_not_installed_and_not_gone_round(index, tmp_path, monkeypatch):
    """pip's own words: a changed file ends it, one that is not there is fetched unlocked."""
    (tmp_path / "a.lock").write_text(f"tampered==1.0 \\\n    --hash=sha256:{'0' * 64}\n")
    commands = []

    def by_pip(command, env=None):
        commands.append(command)
        if "install" not in command or "--target" in command:
            return ""
        where = ["--no-index", "--find-links", str(index), "--target", str(tmp_path / "site")]
        return quietly([sys.executable, "-m", "pip", *command[command.index("install") :], *where])

    quietly = environment.quietly
    monkeypatch.setattr(environment, "quietly", by_pip)
    monkeypatch.setattr(environment, "fetch_uv", lambda: "none here")
    monkeypatch.setattr(places, "LOCK", tmp_path / "a.lock")
    with pytest.raises(starting.SetupError, match=r"does not match its hash in a\.lock") as error:
        environment.install_project(None)
    assert "DO NOT MATCH" in str(error.value)
    assert not any("--editable" in command for command in commands), "installed without hashes"
    assert not (tmp_path / "site").exists()


def test_an_index_that_lacks_a_locked_version_stops_the_setup(monkeypatch):
    done = []

    def no_such_wheel(words, _uv):
        done.append(words)
        wrong = "--require-hashes" in words
        return "  ERROR: No matching distribution found for vtk==9.7.2" if wrong else ""

    monkeypatch.setattr(environment, "install", no_such_wheel)
    with pytest.raises(
        starting.SetupError, match=r"lacks a version that requirements\.lock"
    ) as error:
        environment.install_project(None)
    assert "vtk==9.7.2" in str(error.value)
    assert "python3 dev.py setup --unlocked" in str(error.value)
    assert ["--require-hashes" in words for words in done] == [True]
    environment.install_project(None, unlocked=True)
    assert ["--require-hashes" in words for words in done] == [True, False]


def test_uv_itself_comes_by_its_hash(monkeypatch):
    (pin,) = [h for p, h in locked(places.LOCK) if p.name == "uv"]
    monkeypatch.setattr(environment, "quietly", lambda *_: "not there")
    given = []
    monkeypatch.setattr(environment, "install_hashed", lambda text, *_: given.append(text) or "")
    assert environment.fetch_uv() == ""
    assert re.findall(r"sha256:[0-9a-f]{64}", given[0]) == pin


# -- licences --------------------------------------------------------------------------------------


def test_every_package_that_is_shipped_is_listed_with_its_licence():
    table = list_licences.TABLE.read_text("utf-8")
    assert "(tables/licences.csv)" in list_licences.PAGE.read_text("utf-8")
    shipped = list_licences.shipped(places.BUNDLE_LOCK.read_text("utf-8"))
    wanted = {canonicalize_name(r.name) for r in asked_for("gui") + asked_for("video")}
    assert wanted <= shipped.keys()
    rows = {row[0].split(" ")[0]: row[1] for row in csv.reader(io.StringIO(table))}
    again = "run: python packaging/list_licences.py"
    assert shipped.keys() - rows.keys() == set(), again
    assert all(rows[name].strip() for name in shipped)
    assert list_licences.table() == table, again
    assert not (list_licences.BRINGS.keys() | list_licences.NAMES.keys()) - shipped.keys()


def test_what_only_builds_is_in_no_environment_that_runs():
    """By the metadata of what is installed, not by our list."""
    needed, todo = set(), [("twist-inspector", ("gui", "video"))]
    while todo:
        name, extras = todo.pop()
        for text in metadata.requires(name) or ():
            r = Requirement(text)
            wanted = r.marker is None or any(r.marker.evaluate({"extra": e}) for e in (*extras, ""))
            if wanted and r.name.lower() not in needed:
                needed.add(canonicalize_name(r.name))
                todo.append((r.name, tuple(r.extras)))
    assert len(needed) > 40
    assert needed - list_licences.shipped(places.BUNDLE_LOCK.read_text("utf-8")).keys() == set()


def test_a_bundle_brings_every_licence_file(tmp_path):
    for name in ("numpy", "matplotlib", "PySide6_Essentials"):
        build_bundle.copy_licence_files(metadata.distribution(name), tmp_path / name)
    files = [p for p in metadata.files("numpy") if re.search("licen[cs]e|copying", p.name, re.I)]
    texts = {p.locate().read_bytes() for p in files if p.suffix != ".py"}
    copied = {p.read_bytes() for p in (tmp_path / "numpy").rglob("*") if p.is_file()}
    assert len(texts) > 10
    assert texts <= copied
    assert [*(tmp_path / "matplotlib").rglob("LICENSE_DEJAVU")]
    assert "LGPL-3.0" in (tmp_path / "PySide6_Essentials/LICENCE.txt").read_text("utf-8")
    for text in ("LGPL-3.0.txt", "GPL-3.0.txt"):
        assert "Version 3, 29 June 2007" in (ROOT / "packaging/licences" / text).read_text("utf-8")


def test_what_ffmpeg_says_of_itself_is_what_the_page_says():
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    try:
        program = imageio_ffmpeg.get_ffmpeg_exe()
    except RuntimeError:
        pytest.skip("no ffmpeg in its wheel")
    done = subprocess.run([program, "-version"], capture_output=True, text=True, check=True)
    assert ("--enable-gpl" in done.stdout) == (
        "--enable-gpl" in list_licences.BRINGS["imageio-ffmpeg"]
    )
