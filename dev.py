#!/usr/bin/env python3
"""Set up, run, test and check Twist Inspector from a checkout, on a bare machine too.

    python3 dev.py setup            make .venv, install everything that is missing
    python3 dev.py run [ARGS]       open the program; without a screen, a demonstration into out/
    python3 dev.py test [ARGS]      pytest, e.g. dev.py test -k chain
    python3 dev.py check            lint, format, types, import contracts
    python3 dev.py bench [NAME]     every benchmark, or the one named
    python3 dev.py shot             take the pictures of docs/ from the real window
    python3 dev.py docs [--links]   docs/ as a site in build/site; or whether links out of it work
    python3 dev.py lock [--upgrade]  the lock files after a change of pyproject.toml; or all renewed

Every command sets up first; when nothing is to do that takes a moment. ARGS go to the program
started. Only the standard library is used here, since nothing else is installed yet.
"""

from __future__ import annotations

import collections
import contextlib
import hashlib
import importlib.util
import os
import re
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import IO, TYPE_CHECKING
from xml.etree import ElementTree

# Nothing but the standard library there, either.
from inspector.system_libraries import (
    FONT_PACKAGE,
    has_font,
    has_screen,
    install_command,
    missing_libraries,
)
from twistcore.clip_suffixes import clip_suffix
from twistcore.encoding import legible

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from tests.gui.forked import Forked, Parent

ROOT = Path(__file__).resolve().parent
VENV = ROOT / ".venv"
PYTHON = VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
STAMP = VENV / "twist-inspector.stamp"
OUT = ROOT / "out"
PACKAGES = ["inspector", "twistcore"]
OLDEST_PYTHON = (3, 11)
# Which version of every package is installed here, each file by its hash, for every system and
# Python from the oldest on; and the same for what a bundle is made of. `pip install` of the program
# knows nothing of them: in somebody's environment it must get on with what else is there.
LOCK, BUNDLE_LOCK = ROOT / "requirements.lock", ROOT / "packaging" / "bundle.lock"
LOCKED_EXTRAS = {LOCK: "dev", BUNDLE_LOCK: "bundle"}

# The virtual screen, and the software OpenGL driver that draws on it.
XVFB_PACKAGES = ["xvfb", "libgl1-mesa-dri"]
# Tests that use the program as a person does have a screen of their own, where nothing else is
# seen or typed, with a window manager, with and without a compositor, and real mouse and keys.
TEST_PROGRAMS = {
    "Xvfb": XVFB_PACKAGES,
    "openbox": ["openbox"],
    "xcompmgr": ["xcompmgr"],
    "xdotool": ["xdotool"],
}
# What a lesson's web page is opened in. It is large, 120 MB to fetch and 400 MB on the disk: CI has
# it brought, elsewhere a browser that is there is used.
BROWSER = {"chromium": ["chromium"]}
# What finds faults of a report's pages for people who hear them or have keys only: one script, out
# of a package whose own needs are not wanted. Beside the environment's packages, not among them.
AXE, AXE_FOLDER = "axe-playwright-python==0.1.8", VENV / "axe"
AXE_HASH = "fdd263c998388f1a8e67cad02677e612d946248bd44d163be5e8650ea31f95f8"
QT_API = {"QT_API": "pyside6"}  # QtPy, under pyvistaqt, may see another Qt as well
# The modules of window tests that take longest: first, so that all lanes end together.
LONG = (
    *("nothing_lost", "taken_away", "kill", "test_looks", "starts_and_ends"),
    *("by_hand", "uncovered", "in_browser", "test_teaching", "test_tour"),
)
# Measured with every extra and tool: on the disk, and with what pip unpacks beside it on the way.
VENV_GB, SETUP_GB = 2.0, 3.0
TEST_MINUTES = "about 15 minutes on two cores"


# What pip and uv say where the index cannot be reached, or is not trusted.
CERTIFICATE = re.compile(r"certificate|SSLError|UnknownIssuer", re.IGNORECASE)
CONNECTION = re.compile(
    r"connection|network|resolv|\bdns\b|timed out|unreachable|no route",
    re.IGNORECASE,
)
# What pip says where a file is another than the lock file's, and where that has none that fits.
HASH_DIFFERS = re.compile(r"DO NOT MATCH THE HASHES")
NOT_LOCKED = re.compile(
    r"No matching distribution|Could not find a version|versions pinned with =="
)

# Of graphics drivers that look for hardware which a virtual screen has not, and go on without.
DRIVER_NOISE = re.compile(rb"libGL |libEGL |MESA|glx: |.*(ZINK|zink|failed to load driver)")


class SetupError(Exception):
    """Something a person has to mend; the text says what, in words."""


# --- system libraries ---------------------------------------------------------------------------


def missing_system(*, windows: bool, tests: bool = False) -> dict[str, str]:
    """What the system lacks: library, program or font -> the Debian package that brings it.

    Unless `windows` are to be opened, only what making .venv takes is looked for; `tests` of them
    take some programs more.
    """
    if not sys.platform.startswith("linux"):
        return {}
    missing = {}
    if not (PYTHON.exists() or shutil.which("uv") or importlib.util.find_spec("ensurepip")):
        # Debian ships this part of Python apart.
        missing["ensurepip"] = f"python{sys.version_info[0]}.{sys.version_info[1]}-venv"
    if not windows:
        return missing
    missing |= missing_libraries()
    if not has_screen() and not shutil.which("Xvfb"):
        missing |= {package: package for package in XVFB_PACKAGES}
    wanted = TEST_PROGRAMS | (BROWSER if os.environ.get("CI") else {})
    for program, packages in wanted.items() if tests else ():
        if not shutil.which(program):
            missing |= {package: package for package in packages}
    if not has_font():
        missing["a font"] = FONT_PACKAGE
    return missing


def install_packages(packages: Sequence[str]) -> None:
    """Install Debian packages, or say which command does it where this user may not."""
    install = install_command(packages)
    if not shutil.which("apt-get"):
        raise SetupError(
            f"This system lacks what these Debian packages bring: {' '.join(packages)}.\n"
            "Install their counterparts with your package manager, then try again."
        )
    if os.geteuid() != 0:
        raise SetupError(
            "Some system packages are missing. This one command installs them; then try again:\n"
            f"  sudo apt-get update && sudo {' '.join(install)}"
        )
    say(f"Installing system packages: {' '.join(packages)}")
    env = os.environ | {"DEBIAN_FRONTEND": "noninteractive"}
    # An index that cannot be refreshed may still be good enough: the install is what counts.
    quietly(["apt-get", "update"], env)
    problem = quietly(install, env)
    if problem:
        raise SetupError(f"The system packages could not be installed. apt-get said:\n{problem}")


def ensure_system(*, windows: bool, tests: bool = False) -> None:
    """Bring the libraries, the virtual screen and a font where they are missing."""
    missing = missing_system(windows=windows, tests=tests)
    if missing:
        install_packages(sorted(set(missing.values())))
    importlib.invalidate_caches()  # Python itself may have just become complete
    still = missing_system(windows=windows, tests=tests) if missing else {}
    if still:
        raise SetupError(f"Still not found after the installation: {', '.join(still)}.")


# --- the Python environment ---------------------------------------------------------------------


def venv_version() -> str:
    """The full version of the interpreter in .venv; empty where it is absent or broken."""
    code = f"import sys; print(sys.version if sys.version_info >= {OLDEST_PYTHON} else '')"
    try:
        done = subprocess.run([PYTHON, "-c", code], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return ""
    return done.stdout.strip()


def fingerprint() -> str:
    """Changes whenever the installation has to be repeated, a moved checkout included."""
    files = [ROOT / "pyproject.toml", LOCK]
    parts = [*(file.read_text("utf-8") for file in files), venv_version(), str(ROOT)]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def make_venv(uv: str | None) -> None:
    """Create .venv, in place of one whose interpreter no longer starts."""
    say("Making .venv")
    command = [uv, "venv", "--clear", "--python", sys.executable, str(VENV)] if uv else None
    if command and not quietly(command):
        return
    problem = quietly([sys.executable, "-m", "venv", "--clear", str(VENV)])
    if problem:
        raise SetupError(f".venv could not be made. Python said:\n{problem}")


def install_project(uv: str | None) -> None:
    """Install what the lock file says, then the project, editable; nothing whose hash differs."""
    say(f"Installing the Python packages ({VENV_GB:g} GB on the disk the first time)")
    problem = install(["--require-hashes", "--requirement", str(LOCK)], uv)
    if problem and NOT_LOCKED.search(problem) and not CONNECTION.search(problem):
        say(
            f"{LOCK.name} does not fit this system or this index; the newest versions that "
            f"pyproject.toml allows are installed instead, unverified.\n{problem}"
        )
        problem = install(["--editable", f"{ROOT}[dev]"], uv)
    elif not problem:  # what builds it is locked, too, and there now
        problem = install(["--no-deps", "--no-build-isolation", "--editable", str(ROOT)], uv)
    if problem:
        raise SetupError(f"{why_not_installed(problem)}\npip's last lines:\n{problem}")


def install(words: Sequence[str], uv: str | None) -> str:
    """Install into .venv by uv where possible, else by pip. Empty, or why not in pip's words."""
    python = str(PYTHON)
    with_uv = ["pip", "install", "--compile-bytecode", "--python", python, *words]
    if uv and not quietly([uv, *with_uv]):
        return ""
    pip = [python, "-m", "pip"]
    if quietly([*pip, "--version"]):  # an environment that uv made has no pip
        quietly([python, "-m", "ensurepip"])
    # uv installs several times faster than pip, so that fetching it first pays off.
    if not uv and not fetch_uv() and not quietly([python, "-m", "uv", *with_uv]):
        return ""
    # pip has the last word: it knows settings, such as a mirror in pip.conf, that uv does not.
    return quietly([*pip, "install", "--retries", "2", *words])


def fetch_uv() -> str:
    """The uv of the lock file, into .venv. Empty if it is there, else why not."""
    if not quietly([str(PYTHON), "-m", "uv", "--version"]):
        return ""
    return install_hashed(locked("uv"), "--retries", "1")


def locked(name: str) -> str:
    """What the lock file says of a package: its version, and its hashes on further lines."""
    entries = re.split(r"\n(?=\S)", LOCK.read_text("utf-8"))
    return "\n".join(entry for entry in entries if entry.startswith(f"{name}=="))


def install_hashed(requirement: str, *options: str) -> str:
    """Install by pip what is given with its hashes. Empty, or why not."""
    with tempfile.TemporaryDirectory(prefix="twist-inspector-") as folder:
        file = Path(folder) / "requirements.txt"
        file.write_text(requirement, "utf-8")
        words = ["install", "--require-hashes", "--no-deps", "--requirement", str(file), *options]
        return quietly([str(PYTHON), "-m", "pip", *words])


def why_not_installed(problem: str) -> str:
    """What pip's last lines say is wrong, in words."""
    if HASH_DIFFERS.search(problem):
        return (
            "The Python packages could not be installed: what the package index gave is not what "
            f"{LOCK.name} expects. Somebody may have changed it on the way; it was not installed."
        )
    if CERTIFICATE.search(problem):
        return (
            "The Python packages could not be installed: pip does not trust the certificate of "
            "the package index. Behind a proxy, name its certificate: PIP_CERT=FILE."
        )
    if "No space left" in problem:
        return f"The Python packages could not be installed: no space is left on {ROOT.anchor}."
    if CONNECTION.search(problem):
        return "The Python packages could not be installed; is this machine offline?"
    return "The Python packages could not be installed."


def ensure_room() -> None:
    """Refuse where the installation would fill the disk half-way."""
    free = shutil.disk_usage(ROOT).free / 1e9
    if free < SETUP_GB:
        raise SetupError(
            f"The Python packages take {VENV_GB:g} GB, and {SETUP_GB:g} GB while they are "
            f"installed, but {free:.1f} GB are free for {ROOT}."
        )


def ensure_venv() -> None:
    """Make .venv and install into it, unless the stamp says that this is done."""
    if STAMP.exists() and STAMP.read_text("utf-8") == fingerprint():
        return
    uv = shutil.which("uv")
    if not venv_version():
        ensure_room()
        make_venv(uv)
    install_project(uv)
    # Compiled now, as pip does with what it installs: else the first start takes twice as long,
    # and every start where Python is told to keep nothing.
    quietly([str(PYTHON), "-m", "compileall", "-q", *(str(ROOT / p) for p in PACKAGES)])
    STAMP.write_text(fingerprint(), "utf-8")  # last: an interrupted set-up is repeated


def ensure_axe() -> None:
    """Fetch the script; where it cannot be had the pages are not looked at with it."""
    if any(AXE_FOLDER.rglob("axe.min.js")):
        return
    options = ["--target", str(AXE_FOLDER), "--retries", "1"]
    if problem := install_hashed(f"{AXE} --hash=sha256:{AXE_HASH}", *options):
        say(f"{AXE} could not be fetched; tests that need it are left out.\n{problem}")


# --- starting programs --------------------------------------------------------------------------


def say(text: str) -> None:
    """Tell the person; at once, also into a pipe."""
    print(text, flush=True)


def quietly(command: Sequence[str], env: dict[str, str] | None = None) -> str:
    """Run a command unseen. Empty if it succeeded, else the last lines that say why not."""
    try:
        done = subprocess.run(
            command, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
        )
    except OSError as error:
        return f"  {error}"
    if done.returncode == 0:
        return ""
    lines = [line for line in done.stdout.decode(errors="replace").splitlines() if line.strip()]
    reasons = [line for line in lines if line.lstrip().startswith(("ERROR:", "E:"))]  # pip, apt
    # Why nothing could be fetched stands before them, once a trial; ERROR: says what is lacking.
    causes = [line for line in lines if CERTIFICATE.search(line) or CONNECTION.search(line)]
    told = [*(line for line in causes[-1:] if line not in reasons), *(reasons or lines)[-6:]]
    return "\n".join(f"  {line.strip()}" for line in told) or f"  exit status {done.returncode}"


RUNNING: set[subprocess.Popen[bytes] | Forked] = set()


def start(
    command: Sequence[str],
    env: dict[str, str],
    cwd: Path = ROOT,
    output: IO[bytes] | None = None,
    errors: int | None = None,
) -> int:
    """Run a command in the foreground, or into `output`, and return its exit status.

    Ctrl+C reaches the command itself, so the first is left to it; the second ends it.
    """
    errors = errors if output is None else subprocess.STDOUT
    return finish(subprocess.Popen(command, env=env, cwd=cwd, stdout=output, stderr=errors))


def finish(child: subprocess.Popen[bytes] | Forked) -> int:
    """Wait for what was started, and return its exit status."""
    RUNNING.add(child)
    interrupted = False
    try:
        while True:
            try:
                status = child.wait()
            except KeyboardInterrupt:
                if interrupted:
                    child.terminate()
                interrupted = True
            except SystemExit:  # we were told to end: so is the command
                child.terminate()
                child.wait()
                raise
            else:
                return status if status >= 0 else 128 - status
    finally:
        RUNNING.discard(child)


@contextlib.contextmanager
def without_driver_noise() -> Iterator[int]:
    """Where a program's errors go: on to ours, but for what drivers say of a virtual screen."""
    reader, writer = os.pipe()

    def pass_on() -> None:
        with os.fdopen(reader, "rb") as lines:
            for line in lines:
                if not DRIVER_NOISE.match(line):
                    print(line.decode(errors="replace"), end="", file=sys.stderr, flush=True)

    thread = threading.Thread(target=pass_on, daemon=True)
    thread.start()
    try:
        yield writer
    finally:
        os.close(writer)
        thread.join(5)  # no longer, where something that was left running holds the pipe


@contextlib.contextmanager
def screen() -> Iterator[dict[str, str]]:
    """The environment for a program with windows; a virtual screen where there is no real one."""
    if has_screen():
        yield os.environ | QT_API
        return
    with virtual_screen() as env:
        yield env


@contextlib.contextmanager
def virtual_screen(*options: str) -> Iterator[dict[str, str]]:
    """The environment for a program on a virtual screen of its own; options: of Xvfb."""
    env = os.environ | QT_API
    reader, writer = os.pipe()
    command = ["Xvfb", "-displayfd", str(writer), "-screen", "0", "1920x1080x24"]
    command += ["+extension", "GLX", "+render", "-noreset", *options]
    with tempfile.TemporaryDirectory(prefix="twist-inspector-") as scratch:
        # A session of its own, so that Ctrl+C does not take the screen from under the program.
        server = subprocess.Popen(
            command,
            pass_fds=[writer],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        try:
            os.close(writer)
            env |= {"DISPLAY": f":{read_line(reader, seconds=30)}", "QT_QPA_PLATFORM": "xcb"}
            env.setdefault("XDG_RUNTIME_DIR", scratch)  # Qt complains without one
            yield env
        finally:
            os.close(reader)
            server.terminate()
            server.wait()


def read_line(descriptor: int, seconds: float) -> str:
    """The number that Xvfb writes once it is ready."""
    line = b""
    while not line.endswith(b"\n"):
        ready, _, _ = select.select([descriptor], [], [], seconds)
        chunk = os.read(descriptor, 16) if ready else b""
        if not chunk:
            raise SetupError(
                "The virtual screen (Xvfb) did not start; run Xvfb by hand to see why."
            )
        line += chunk
    return line.decode().strip()


# --- commands -----------------------------------------------------------------------------------


def default_clip() -> Path:
    """The sample with injected errors: the one whose truth lies beside it."""
    clips = sorted((ROOT / "assets").glob("*.truth.json"))
    names = [clip.with_name(clip.name.removesuffix(".truth.json") + ".bvh") for clip in clips]
    preferred = ROOT / "assets/walk_injected.bvh"
    for clip in [preferred, *names]:
        if clip.exists():
            return clip
    raise SetupError("No sample clip in assets/; name a BVH file: python3 dev.py run CLIP")


def command_run(args: list[str]) -> int:
    """Open the program; where nobody can see it, let it show itself and leave the results."""
    if has_screen() or {"--demo", "--screenshot", "--help", "-h", "--version"} & set(args):
        words = args or [str(default_clip())]
        with screen() as env:
            return start([str(PYTHON), "-m", "inspector", *words], env, Path.cwd())
    began = time.time() - 1  # some file systems keep whole seconds
    with screen() as env:
        status = show_clip(args, env) if args else demonstrate(env)
    if status == 0:
        tell_results(began)
    return status


def demonstrate(env: dict[str, str]) -> int:
    """A review of the sample that nobody makes: everything is accepted."""
    clip = default_clip()
    say(
        f"No screen here: a demonstration with {clip.name} on a virtual one. It accepts whatever "
        "is found, though nobody has seen it."
    )
    return start_unseen([str(clip), "--demo", str(OUT)], env)


def show_clip(args: list[str], env: dict[str, str]) -> int:
    """A picture of somebody's own clip and what is found in it; nobody is there to decide."""
    say("No screen here: a picture is taken on a virtual one, and nothing is decided.")
    status = start_unseen([*args, "--screenshot", str(OUT / "inspector.png")], env)
    if status == 0 and clip_suffix(args[0]):
        say(f"Found in {legible(args[0])}:")
        status = start([str(PYTHON), "-m", "twistcore", "detect", args[0]], env, Path.cwd())
        # 1: there is no chain, which it has said; the picture is there all the same.
        status = 0 if status == 1 else status
        say("Nothing was decided or corrected, and the file is as it was.")
    return status


def start_unseen(words: list[str], env: dict[str, str]) -> int:
    """The program on a virtual screen."""
    with without_driver_noise() as errors:
        command = [str(PYTHON), "-m", "inspector", *words]
        return start(command, env, Path.cwd(), errors=errors)


def tell_results(began: float) -> None:
    """Say in plain words what was left in out/, in its folders too."""
    kinds = {
        ".png": "picture of the window",
        ".bvh": "corrected motion: only what was accepted has changed",
        ".html": "report, to be opened in a browser",
        ".csv": "report as a table",
        ".json": "report or session, for programs",
        ".py": "marks of the intervals, for a program of animation",
        ".srt": "subtitles",
        ".webm": "film",
        ".mp4": "film",
    }
    say(f"Left in {OUT}:")
    files = [f for f in sorted(OUT.rglob("*")) if f.is_file() and f.stat().st_mtime >= began]
    names = [legible(file.relative_to(OUT).as_posix()) for file in files]
    width = max(map(len, names), default=0)
    for file, name in zip(files, names, strict=True):
        say(f"  {name:<{width}}  {kinds.get(file.suffix.lower(), '')}".rstrip())
    say("With a screen, the same command opens the window.")


def command_test(args: list[str]) -> int:
    """Run pytest; without arguments all of it, every module of window tests by itself.

    Three parts at a time where each has a virtual screen of its own: on a real one windows would
    take each other's keys, and only what has no windows runs beside them.
    """
    if args:
        with screen() as env:
            return start([str(PYTHON), "-m", "pytest", *args], env)
    say(f"All tests take {TEST_MINUTES}; dev.py test -k WORD runs some.")
    counts: collections.Counter[str] = collections.Counter()
    notes: list[str] = []

    def run_twice(part: list[str], parent: Parent | None = None) -> int:
        with tempfile.TemporaryFile() as output:
            done = run_part(part, output, parent)
            if done is None and not given_up:  # it crashed, or hung until pytest gave it up
                notes.append(f"{part[0]}: its process did not come to its end and was run again.")
                done = run_part(part, output, parent)
            output.seek(0)
            say(output.read().decode(errors="replace"))
        counts.update(done or {"failed": 1})
        return int(not done or done["failed"] > 0)

    def test_windows() -> int:
        status = 0
        # A program has one window: hundreds in one process try Qt's bindings, not the program.
        for module in waiting:  # one list for all lanes
            status |= 0 if given_up else run_twice([module], parent)
        return status

    def test_the_rest() -> int:
        status = run_twice(["tests", "--ignore=tests/gui"])
        return status if has_screen() else status | test_windows()

    waiting, given_up = iter(window_tests()), False
    # Windows wait for half their time, on the screen and on each other: a core has room for more.
    more = [test_windows] if not has_screen() else []
    with parent_of_tests() as parent, ThreadPoolExecutor(3) as lanes:
        running = [lanes.submit(lane) for lane in (test_the_rest, test_windows, *more)]
        try:
            status = max([lane.result() for lane in running])
        except BaseException:  # Ctrl+C, or we were told to end
            given_up = True
            for child in tuple(RUNNING):
                child.terminate()
            raise
    for note in notes:
        say(note)
    say(f"{counts['passed']} passed, {counts['failed']} failed, {counts['skipped']} skipped")
    return status


def window_tests() -> list[str]:
    """The modules of window tests, the long ones first."""
    files = sorted(ROOT.glob("tests/gui/test_*.py"))
    files.sort(key=lambda file: not any(name in file.name for name in LONG))
    return [file.relative_to(ROOT).as_posix() for file in files]


@contextlib.contextmanager
def parent_of_tests() -> Iterator[Parent | None]:
    """What has imported all that window tests need; None where processes cannot be forked off."""
    if not sys.platform.startswith("linux"):
        yield None
        return
    from tests.gui.forked import Parent

    parent = Parent(str(PYTHON), QT_API)
    try:
        yield parent
    finally:
        parent.end()


def run_part(
    part: list[str], output: IO[bytes] | None = None, parent: Parent | None = None
) -> collections.Counter[str] | None:
    """Run some of the tests on a screen of their own and count; None if pytest did not end.

    What it says goes to `output`, or to where we say things. parent: it is forked off that.
    """
    with tempfile.TemporaryDirectory(prefix="twist-inspector-") as folder, screen() as env:
        report = Path(folder) / "report.xml"
        words = ["-m", "pytest", f"--junitxml={report}", *part]
        forked = run_forked(parent, words, env, output) if parent and output else None
        status = start([str(PYTHON), *words], env, ROOT, output) if forked is None else forked
        if status > 2 or not report.exists():
            return None
        suite = ElementTree.parse(report).getroot()[0]
    number = {key: int(value) for key, value in suite.attrib.items() if value.isdecimal()}
    failed = number["failures"] + number["errors"]
    if status == 2 and not failed:
        raise KeyboardInterrupt
    passed = number["tests"] - failed - number["skipped"]
    failed = failed or status  # what went wrong outside of any test
    return collections.Counter(passed=passed, failed=failed, skipped=number["skipped"])


def run_forked(
    parent: Parent, words: list[str], env: dict[str, str], output: IO[bytes]
) -> int | None:
    """The exit status of Python, forked off; None where it is not known, as its parent is gone."""
    try:
        with contextlib.closing(parent.start(words, env, output, ROOT)) as child:
            try:
                return finish(child)
            except (OSError, ValueError):  # it may go on, on the screen that is needed
                os.kill(child.pid, signal.SIGKILL)
    except (OSError, AssertionError):
        pass
    return None


def command_check(args: list[str]) -> int:
    """Run every check, also after one failed, so that one run shows all that is wrong."""
    if args:
        raise SetupError(f"check takes no arguments, but got: {legible(' '.join(args))}")
    python = str(PYTHON)
    # Not the script lint-imports: its first line names a path that goes stale in a moved checkout.
    lint_imports = "from importlinter.cli import lint_imports_command as lint; lint()"
    checks = {
        "ruff check": [python, "-m", "ruff", "check"],
        "ruff format": [python, "-m", "ruff", "format", "--check"],
        "mypy": [python, "-m", "mypy"],
        "import contracts": [python, "-c", lint_imports],
    }
    failed = []
    for name, command in checks.items():
        say(f"--- {name}")
        if start(command, dict(os.environ)):
            failed.append(name)
    say(f"Failed: {', '.join(failed)}." if failed else "All checks passed.")
    return 1 if failed else 0


def command_bench(args: list[str]) -> int:
    """Run every benchmark, or the one named, with the remaining arguments."""
    names = sorted(file.stem for file in (ROOT / "benchmarks").glob("[!_]*.py"))
    if args and not args[0].startswith("-"):
        if args[0] not in names:
            raise SetupError(f"No benchmark {args[0]!a}; there are: {', '.join(names) or 'none'}.")
        names, args = args[:1], args[1:]
    status = 0
    with screen() as env:
        for name in names:
            say(f"--- {name}")
            status |= start([str(PYTHON), "-m", f"benchmarks.{name}", *args], env)
    return status


def command_shot(args: list[str]) -> int:
    """Take the pictures of the documentation from the real window."""
    with screen() as env:
        return start([str(PYTHON), "-m", "inspector.shots", *args], env)


def command_docs(args: list[str]) -> int:
    """Build the site, where every warning is an error; with --links ask for what it links to."""
    if args not in ([], ["--links"]):
        raise SetupError(f"docs takes --links or nothing, but got: {legible(' '.join(args))}")
    way, where = ("linkcheck", "build/links") if args else ("html", "build/site")
    # Warnings of a page are said when it is read: all are.
    words = ["-m", "sphinx", "-q", "-E", "-W", "--keep-going", "-n", "-b", way, "docs", where]
    status = start([str(PYTHON), *words], dict(os.environ))
    if status == 0:
        say("Every link out of docs/ works." if args else f"{ROOT / where / 'index.html'}")
    return status


def command_lock(args: list[str]) -> int:
    """Write the lock files anew; what they name stays as it is where it still fits."""
    if args not in ([], ["--upgrade"]):
        raise SetupError(f"lock takes --upgrade or nothing, but got: {' '.join(args)}")
    oldest = ".".join(map(str, OLDEST_PYTHON))
    words = ["pip", "compile", "--universal", "--python-version", oldest, "--generate-hashes"]
    words += ["--no-emit-index-url", "--no-annotate", "--no-config", "--quiet", *args]
    words += ["--custom-compile-command", "python3 dev.py lock"]
    for file, extra in LOCKED_EXTRAS.items():
        # One version of each package, wherever it is installed.
        same = ["--constraint", LOCK.name] if file != LOCK else []
        to = ["--extra", extra, *same, "pyproject.toml", "--output-file", str(file)]
        status = start([str(PYTHON), "-m", "uv", *words, *to], dict(os.environ))
        if status:
            return status
    return 0


COMMANDS = {
    "run": command_run,
    "test": command_test,
    "check": command_check,
    "bench": command_bench,
    "shot": command_shot,
    "docs": command_docs,
    "lock": command_lock,
}


def main(argv: list[str]) -> int:
    """Set up what is missing, then do what was asked. Exit 2 where a person has to act."""
    if sys.version_info < OLDEST_PYTHON:
        say("Twist Inspector needs Python 3.11 or newer; this is Python " + sys.version.split()[0])
        return 2
    name = argv[0] if argv else "--help"
    if name in {"-h", "--help", "help"}:
        say(__doc__.strip())
        return 0
    if name != "setup" and name not in COMMANDS:
        say(f"No command {name!a}. There are: setup, {', '.join(COMMANDS)}.")
        return 2
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # so that the screen is put away
    try:
        ensure_system(windows=name not in {"check", "docs", "lock"}, tests=name == "test")
        ensure_venv()
        if name == "test":
            ensure_axe()
        if name == "setup":
            say(f"Ready. {PYTHON.parent} has everything; try: python3 dev.py run")
            return 0
        return COMMANDS[name](argv[1:])
    except SetupError as error:
        say(str(error))
    except KeyboardInterrupt:
        say("Interrupted.")
        return 130
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
