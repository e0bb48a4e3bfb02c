"""The Python environment of a checkout in `.venv`, and its lock files."""

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
# The package with a script that checks the accessibility of a report's pages. Only the script is
# used, so the package is installed in a separate folder, without its dependencies.
AXE, AXE_FOLDER = "axe-playwright-python==0.1.8", places.VENV / "axe"
AXE_HASH = "fdd263c998388f1a8e67cad02677e612d946248bd44d163be5e8650ea31f95f8"
# The disk space that .venv needs with all extras, and that its installation needs temporarily.
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
    say("Making .venv")
    command = [uv, "venv", "--clear", "--python", sys.executable, str(places.VENV)] if uv else None
    if command and not quietly(command):
        return
    problem = quietly([sys.executable, "-m", "venv", "--clear", str(places.VENV)])
    if problem:
        raise SetupError(f".venv could not be made. Python said:\n{problem}")


def install_project(uv: str | None) -> None:
    """Install the locked packages, and then the project as an editable package.

    If a file has another hash than in the lock file, nothing is installed. If no locked version
    exists for this system, install the newest versions that pyproject.toml allows.
    """
    say(f"Installing the Python packages ({VENV_GB:g} GB on the disk the first time)")
    problem = install(["--require-hashes", "--requirement", str(places.LOCK)], uv)
    if problem and NOT_LOCKED.search(problem) and not CONNECTION.search(problem):
        say(
            f"{places.LOCK.name} does not fit this system or this index; the newest versions that "
            f"pyproject.toml allows are installed instead, unverified.\n{problem}"
        )
        problem = install(["--editable", f"{places.ROOT}[dev]"], uv)
    elif not problem:  # its build tools are locked, and installed by now
        problem = install(["--no-deps", "--no-build-isolation", "--editable", str(places.ROOT)], uv)
    if problem:
        raise SetupError(f"{why_not_installed(problem)}\npip's last lines:\n{problem}")


def install(words: Sequence[str], uv: str | None) -> str:
    """Install into .venv with uv if possible, or else with pip.

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
    """Return the entry of a package in the lock file: its version, and its hashes."""
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
    """Return an explanation of the last lines of pip."""
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
    """Raise SetupError if the disk has too little free space for the installation."""
    free = shutil.disk_usage(places.ROOT).free / 1e9
    if free < SETUP_GB:
        raise SetupError(
            f"The Python packages take {VENV_GB:g} GB, and {SETUP_GB:g} GB while they are "
            f"installed, but {free:.1f} GB are free for {places.ROOT}."
        )


def ensure_venv() -> None:
    """Create .venv and install into it, unless a stamp shows that this has been done."""
    if places.STAMP.exists() and places.STAMP.read_text("utf-8") == fingerprint():
        return
    uv = shutil.which("uv")
    if not venv_version():
        ensure_room()
        make_venv(uv)
    install_project(uv)
    # Compile now, as pip does for installed packages. Without this, the first start takes twice as
    # long, and so does every start if Python writes no bytecode.
    folders = [str(places.ROOT / package) for package in PACKAGES]
    quietly([str(places.PYTHON), "-m", "compileall", "-q", *folders])
    places.STAMP.write_text(fingerprint(), "utf-8")  # last, so an interrupted set-up is repeated


def ensure_axe() -> None:
    """Download the script that checks accessibility. Without it, some tests are skipped."""
    if any(AXE_FOLDER.rglob("axe.min.js")):
        return
    options = ["--target", str(AXE_FOLDER), "--retries", "1"]
    if problem := install_hashed(f"{AXE} --hash=sha256:{AXE_HASH}", *options):
        say(f"{AXE} could not be fetched; tests that need it are left out.\n{problem}")


def write_locks(options: Sequence[str]) -> int:
    """Update the lock files, and keep versions that still fit. `options` are options of uv."""
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
