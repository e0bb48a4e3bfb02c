"""The Python environment of a checkout in `.venv`, and its lock files."""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING

from checkout import places
from checkout.starting import CERTIFICATE, CONNECTION, SetupError, quietly, say, start

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

PACKAGES = ["inspector", "twistcore"]
OLDEST_PYTHON = (3, 11)
LOCKED_EXTRAS = {places.LOCK: "dev", places.BUNDLE_LOCK: "bundle"}
# The package with a script that checks the accessibility of a report's pages. Only the script is
# used, so the package is installed in a separate folder, without its dependencies.
AXE, AXE_FOLDER = "axe-playwright-python==0.1.8", places.VENV / "axe"
AXE_HASH = "fdd263c998388f1a8e67cad02677e612d946248bd44d163be5e8650ea31f95f8"
UNLOCKED = "--unlocked"
UNLOCKED_COMMAND = f"python3 dev.py setup {UNLOCKED}"
# Measured with every extra and tool: installed, and including the temporary files of pip.
VENV_GB, SETUP_GB = 2.0, 3.0
# Messages of pip if a file has the wrong hash, and if the lock file has no suitable version.
HASH_DIFFERS = re.compile(r"DO NOT MATCH THE HASHES")
NOT_LOCKED = re.compile(
    r"No matching distribution|Could not find a version|versions pinned with =="
)


def venv_version() -> str:
    """Return the full version of the Python in .venv, or '' if it is missing, broken or too old."""
    code = f"import sys; print(sys.version if sys.version_info >= {OLDEST_PYTHON} else '')"
    try:
        command = [str(places.PYTHON), "-c", code]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return ""
    return done.stdout.strip()


def fingerprint() -> str:
    """Return a hash that changes whenever the packages must be installed again.

    It depends on pyproject.toml, the lock file, the Python version and the path of the checkout.
    """
    files = [places.ROOT / "pyproject.toml", places.LOCK]
    parts = [*(file.read_text("utf-8") for file in files), venv_version(), str(places.ROOT)]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def make_venv(uv: str | None) -> None:
    """Create .venv, and replace an existing one.

    Raise SetupError if it cannot be created. `uv` is the path of uv, or None.
    """
    say("Creating .venv")
    command = [uv, "venv", "--clear", "--python", sys.executable, str(places.VENV)] if uv else None
    if command and not quietly(command):
        return
    problem = quietly([sys.executable, "-m", "venv", "--clear", str(places.VENV)])
    if problem:
        raise SetupError(f".venv could not be created. Python's message:\n{problem}")


def install_project(uv: str | None, *, unlocked: bool = False) -> None:
    """Install the locked packages, checking their hashes, then the project in editable mode.

    With `unlocked`, install the newest versions that pyproject.toml allows instead.
    """
    say(f"Installing the Python packages ({VENV_GB:g} GB the first time)")
    with showing_progress():
        if unlocked:
            problem = install(["--editable", f"{places.ROOT}[dev]"], uv)
        else:
            problem = install(["--require-hashes", "--requirement", str(places.LOCK)], uv)
            if not problem:  # the build tools are also locked, and installed now
                words = ["--no-deps", "--no-build-isolation", "--editable", str(places.ROOT)]
                problem = install(words, uv)
    if problem:
        raise SetupError(f"{why_not_installed(problem)}\npip's last lines:\n{problem}")


@contextlib.contextmanager
def showing_progress(every_s: float = 10.0) -> Iterator[None]:
    """Print the elapsed time and the disk space used at regular intervals."""
    begun, free = time.monotonic(), free_bytes(places.ROOT)
    done = threading.Event()

    def tell() -> None:
        while not done.wait(every_s):
            gigabytes = max(free - free_bytes(places.ROOT), 0) / 1e9
            say(f"  {time.monotonic() - begun:.0f} s, {gigabytes:.1f} GB written")

    thread = threading.Thread(target=tell, daemon=True)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


def free_bytes(folder: Path) -> int:
    """Return the free bytes on a folder's disk."""
    return shutil.disk_usage(folder).free


def install(words: Sequence[str], uv: str | None) -> str:
    """Install into .venv with uv or, if that fails, with pip.

    `words` are the arguments of `pip install`. Return '' on success, or the last lines of pip.
    """
    python = str(places.PYTHON)
    with_uv = ["pip", "install", "--compile-bytecode", "--python", python, *words]
    if uv and not quietly([uv, *with_uv]):
        return ""
    pip = [python, "-m", "pip"]
    if quietly([*pip, "--version"]):  # an environment that uv made has no pip
        quietly([python, "-m", "ensurepip"])
    # uv installs several times faster than pip, so it is worth installing first.
    if not uv and not fetch_uv() and not quietly([python, "-m", "uv", *with_uv]):
        return ""
    # If uv fails, pip may still succeed, because it reads settings such as a mirror in pip.conf.
    return quietly([*pip, "install", "--retries", "2", *words])


def fetch_uv() -> str:
    """Install the locked version of uv into .venv. Return '' on success, or an error message."""
    if not quietly([str(places.PYTHON), "-m", "uv", "--version"]):
        return ""
    return install_hashed(locked("uv"), "--retries", "1")


def locked(name: str) -> str:
    """Return a package's entry in the lock file: its version and hashes."""
    entries = re.split(r"\n(?=\S)", places.LOCK.read_text("utf-8"))
    return "\n".join(entry for entry in entries if entry.startswith(f"{name}=="))


def install_hashed(requirement: str, *options: str) -> str:
    """Install a package with pip, given its version and hashes.

    Return '' on success, or an error message.
    """
    with tempfile.TemporaryDirectory(prefix="twist-inspector-") as folder:
        file = Path(folder) / "requirements.txt"
        file.write_text(requirement, "utf-8")
        words = ["install", "--require-hashes", "--no-deps", "--requirement", str(file), *options]
        return quietly([str(places.PYTHON), "-m", "pip", *words])


def why_not_installed(problem: str) -> str:
    """Explain pip's last lines in a sentence."""
    if HASH_DIFFERS.search(problem):
        return (
            "The Python packages could not be installed: a download does not match its hash in "
            f"{places.LOCK.name}, so it may have been tampered with. It was not installed."
        )
    if CERTIFICATE.search(problem):
        return (
            "The Python packages could not be installed: pip does not trust the certificate of "
            "the package index. Behind a proxy, set PIP_CERT to the file of its certificate."
        )
    if "No space left" in problem:
        disk = places.ROOT.anchor
        return f"The Python packages could not be installed: there is no space left on {disk}."
    if NOT_LOCKED.search(problem) and not CONNECTION.search(problem):
        return (
            f"The Python packages could not be installed: the package index lacks a version that "
            f"{places.LOCK.name} requires on this system. Use an index that has it, or install the "
            "newest versions that pyproject.toml allows, which are untested: "
            f"{UNLOCKED_COMMAND}."
        )
    if CONNECTION.search(problem):
        return "The Python packages could not be installed; is this machine offline?"
    return "The Python packages could not be installed."


def ensure_room() -> None:
    """Raise SetupError if a disk has too little space for the installation.

    Files of an interrupted installation count as installed. pip and uv unpack into a temporary
    folder and a cache, which may be on other disks.
    """
    spare = SETUP_GB - VENV_GB
    missing = VENV_GB - sum(one.lstat().st_size for one in places.VENV.rglob("*")) / 1e9
    if missing < spare:  # most of it is installed: other versions, or the project has moved
        return
    needed = {places.ROOT: missing}
    for folder in unpacking_folders():
        disk = places.ROOT if disk_of(folder) == disk_of(places.ROOT) else folder
        needed[disk] = missing + spare if disk == places.ROOT else spare
    for folder, gigabytes in needed.items():
        free = free_bytes(folder) / 1e9
        if free < gigabytes:
            raise SetupError(
                f"The Python packages need {VENV_GB:g} GB ({SETUP_GB:g} GB during installation). "
                f"{folder} needs {gigabytes:.1f} GB, but only {free:.1f} GB are free there."
            )


def disk_of(folder: Path) -> int:
    """Return the device number of a folder's disk."""
    return folder.stat().st_dev


def unpacking_folders() -> list[Path]:
    """Return the folders in which pip and uv unpack, or their nearest existing parents."""
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    cache = Path(os.environ.get("UV_CACHE_DIR") or os.environ.get("PIP_CACHE_DIR") or home)
    return [
        next(folder for folder in (one, *one.parents) if folder.is_dir())
        for one in (Path(tempfile.gettempdir()), cache.absolute())
    ]


def ensure_venv(*, unlocked: bool = False) -> None:
    """Create .venv and install into it, unless the stamp shows that this is done."""
    if places.STAMP.exists() and places.STAMP.read_text("utf-8") == fingerprint():
        return
    uv = shutil.which("uv")
    ensure_room()
    if not venv_version():
        make_venv(uv)
    install_project(uv, unlocked=unlocked)
    # Compile the modules now, as pip does for packages. Without this, the first start would take
    # twice as long, and so would every start if Python may not store compiled modules.
    folders = [str(places.ROOT / package) for package in PACKAGES]
    quietly([str(places.PYTHON), "-m", "compileall", "-q", *folders])
    places.STAMP.write_text(fingerprint(), "utf-8")  # last, so an interrupted set-up is repeated


def ensure_axe() -> None:
    """Download the script that checks accessibility. Without it, some tests are skipped."""
    if any(AXE_FOLDER.rglob("axe.min.js")):
        return
    options = ["--target", str(AXE_FOLDER), "--retries", "1"]
    if problem := install_hashed(f"{AXE} --hash=sha256:{AXE_HASH}", *options):
        say(f"{AXE} could not be downloaded. Tests that need it are skipped.\n{problem}")


def write_locks(options: Sequence[str]) -> int:
    """Update the lock files, keeping versions that still fit. `options` are passed to uv."""
    oldest = ".".join(map(str, OLDEST_PYTHON))
    words = ["pip", "compile", "--universal", "--python-version", oldest, "--generate-hashes"]
    words += ["--no-emit-index-url", "--no-annotate", "--no-config", "--quiet", *options]
    words += ["--custom-compile-command", "python3 dev.py lock"]
    for file, extra in LOCKED_EXTRAS.items():
        # All lock files have the same version of each package.
        same = ["--constraint", places.LOCK.name] if file != places.LOCK else []
        to = ["--extra", extra, *same, "pyproject.toml", "--output-file", str(file)]
        status = start([str(places.PYTHON), "-m", "uv", *words, *to], dict(os.environ))
        if status:
            return status
    return 0
