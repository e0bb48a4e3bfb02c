"""The Python environment of a checkout: `.venv`, what the lock file says, and the lock files."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from checkout import places
from checkout.starting import CERTIFICATE, CONNECTION, SetupError, quietly, say, start

if TYPE_CHECKING:
    from collections.abc import Sequence

PACKAGES = ["inspector", "twistcore"]
OLDEST_PYTHON = (3, 11)
LOCKED_EXTRAS = {places.LOCK: "dev", places.BUNDLE_LOCK: "bundle"}
# What finds faults of a report's pages for people who hear them or have keys only: one script, out
# of a package whose own needs are not wanted. Beside the environment's packages, not among them.
AXE, AXE_FOLDER = "axe-playwright-python==0.1.8", places.VENV / "axe"
AXE_HASH = "fdd263c998388f1a8e67cad02677e612d946248bd44d163be5e8650ea31f95f8"
# Measured with every extra and tool: on the disk, and with what pip unpacks beside it on the way.
VENV_GB, SETUP_GB = 2.0, 3.0
# What pip says where a file is another than the lock file's, and where that has none that fits.
HASH_DIFFERS = re.compile(r"DO NOT MATCH THE HASHES")
NOT_LOCKED = re.compile(
    r"No matching distribution|Could not find a version|versions pinned with =="
)


def venv_version() -> str:
    """The full version of the interpreter in .venv; empty where it is absent or broken."""
    code = f"import sys; print(sys.version if sys.version_info >= {OLDEST_PYTHON} else '')"
    try:
        command = [str(places.PYTHON), "-c", code]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return ""
    return done.stdout.strip()


def fingerprint() -> str:
    """Changes whenever the installation has to be repeated, a moved checkout included."""
    files = [places.ROOT / "pyproject.toml", places.LOCK]
    parts = [*(file.read_text("utf-8") for file in files), venv_version(), str(places.ROOT)]
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


def make_venv(uv: str | None) -> None:
    """Create .venv, in place of one whose interpreter no longer starts."""
    say("Making .venv")
    command = [uv, "venv", "--clear", "--python", sys.executable, str(places.VENV)] if uv else None
    if command and not quietly(command):
        return
    problem = quietly([sys.executable, "-m", "venv", "--clear", str(places.VENV)])
    if problem:
        raise SetupError(f".venv could not be made. Python said:\n{problem}")


def install_project(uv: str | None) -> None:
    """Install what the lock file says, then the project, editable; nothing whose hash differs."""
    say(f"Installing the Python packages ({VENV_GB:g} GB on the disk the first time)")
    problem = install(["--require-hashes", "--requirement", str(places.LOCK)], uv)
    if problem and NOT_LOCKED.search(problem) and not CONNECTION.search(problem):
        say(
            f"{places.LOCK.name} does not fit this system or this index; the newest versions that "
            f"pyproject.toml allows are installed instead, unverified.\n{problem}"
        )
        problem = install(["--editable", f"{places.ROOT}[dev]"], uv)
    elif not problem:  # what builds it is locked, too, and there now
        problem = install(["--no-deps", "--no-build-isolation", "--editable", str(places.ROOT)], uv)
    if problem:
        raise SetupError(f"{why_not_installed(problem)}\npip's last lines:\n{problem}")


def install(words: Sequence[str], uv: str | None) -> str:
    """Install into .venv by uv where possible, else by pip. Empty, or why not in pip's words."""
    python = str(places.PYTHON)
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
    if not quietly([str(places.PYTHON), "-m", "uv", "--version"]):
        return ""
    return install_hashed(locked("uv"), "--retries", "1")


def locked(name: str) -> str:
    """What the lock file says of a package: its version, and its hashes on further lines."""
    entries = re.split(r"\n(?=\S)", places.LOCK.read_text("utf-8"))
    return "\n".join(entry for entry in entries if entry.startswith(f"{name}=="))


def install_hashed(requirement: str, *options: str) -> str:
    """Install by pip what is given with its hashes. Empty, or why not."""
    with tempfile.TemporaryDirectory(prefix="twist-inspector-") as folder:
        file = Path(folder) / "requirements.txt"
        file.write_text(requirement, "utf-8")
        words = ["install", "--require-hashes", "--no-deps", "--requirement", str(file), *options]
        return quietly([str(places.PYTHON), "-m", "pip", *words])


def why_not_installed(problem: str) -> str:
    """What pip's last lines say is wrong, in words."""
    if HASH_DIFFERS.search(problem):
        return (
            "The Python packages could not be installed: what the package index gave is not what "
            f"{places.LOCK.name} expects. Somebody may have changed it on the way; it was not "
            "installed."
        )
    if CERTIFICATE.search(problem):
        return (
            "The Python packages could not be installed: pip does not trust the certificate of "
            "the package index. Behind a proxy, name its certificate: PIP_CERT=FILE."
        )
    if "No space left" in problem:
        disk = places.ROOT.anchor
        return f"The Python packages could not be installed: no space is left on {disk}."
    if CONNECTION.search(problem):
        return "The Python packages could not be installed; is this machine offline?"
    return "The Python packages could not be installed."


def ensure_room() -> None:
    """Refuse where the installation would fill the disk half-way."""
    free = shutil.disk_usage(places.ROOT).free / 1e9
    if free < SETUP_GB:
        raise SetupError(
            f"The Python packages take {VENV_GB:g} GB, and {SETUP_GB:g} GB while they are "
            f"installed, but {free:.1f} GB are free for {places.ROOT}."
        )


def ensure_venv() -> None:
    """Make .venv and install into it, unless the stamp says that this is done."""
    if places.STAMP.exists() and places.STAMP.read_text("utf-8") == fingerprint():
        return
    uv = shutil.which("uv")
    if not venv_version():
        ensure_room()
        make_venv(uv)
    install_project(uv)
    # Compiled now, as pip does with what it installs: else the first start takes twice as long,
    # and every start where Python is told to keep nothing.
    folders = [str(places.ROOT / package) for package in PACKAGES]
    quietly([str(places.PYTHON), "-m", "compileall", "-q", *folders])
    places.STAMP.write_text(fingerprint(), "utf-8")  # last: an interrupted set-up is repeated


def ensure_axe() -> None:
    """Fetch the script; where it cannot be had the pages are not looked at with it."""
    if any(AXE_FOLDER.rglob("axe.min.js")):
        return
    options = ["--target", str(AXE_FOLDER), "--retries", "1"]
    if problem := install_hashed(f"{AXE} --hash=sha256:{AXE_HASH}", *options):
        say(f"{AXE} could not be fetched; tests that need it are left out.\n{problem}")


def write_locks(options: Sequence[str]) -> int:
    """Write the lock files anew; what they name stays where it still fits. options: uv's."""
    oldest = ".".join(map(str, OLDEST_PYTHON))
    words = ["pip", "compile", "--universal", "--python-version", oldest, "--generate-hashes"]
    words += ["--no-emit-index-url", "--no-annotate", "--no-config", "--quiet", *options]
    words += ["--custom-compile-command", "python3 dev.py lock"]
    for file, extra in LOCKED_EXTRAS.items():
        # One version of each package, wherever it is installed.
        same = ["--constraint", places.LOCK.name] if file != places.LOCK else []
        to = ["--extra", extra, *same, "pyproject.toml", "--output-file", str(file)]
        status = start([str(places.PYTHON), "-m", "uv", *words, *to], dict(os.environ))
        if status:
            return status
    return 0
