"""A batch folder at a URL: a run works in a folder here, and brings it there at its end."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import platformdirs

from twistcore.atomic import write_atomically
from twistcore.batch.manifest import FILE
from twistcore.batch.remote_files import find_remote, read_remote, write_remote
from twistcore.file_marks import sha256_of

_BROUGHT = ".brought.json"  # SHA-256 of what lies at the URL, by path below it


@contextmanager
def working_folder(output: str) -> Iterator[Path]:
    """The folder itself; of a URL one here that is as that is, and at the end is brought there.

    Brought is what changed, the manifest last, so that it never tells of what is not there. A run
    that is killed brings nothing; the next one here does. TwistError where the URL cannot be read
    or written.
    """
    if "://" not in output:
        yield Path(output)
        return
    url = output.rstrip("/")
    name = hashlib.sha256(url.encode()).hexdigest()[:16]
    folder = Path(platformdirs.user_cache_dir("twist-inspector")) / "batch" / name
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / FILE).exists():
        _fetch(url, folder)
    try:
        yield folder
    finally:
        _bring(folder, url)


def _fetch(url: str, folder: Path) -> None:
    """What a run before this one left there, if there was one; the manifest last, too."""
    there = {name: path for path, name, _ in find_remote(url, may_be_none=True)}
    if FILE not in there:
        return
    brought = {}
    for name in sorted(there, key=lambda name: name == FILE):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, read_remote(there[name]))
        brought[name] = sha256_of(path)
    write_atomically(folder / _BROUGHT, json.dumps(brought).encode())


def _bring(folder: Path, url: str) -> None:
    listing = folder / _BROUGHT
    brought = json.loads(listing.read_text("utf-8")) if listing.exists() else {}
    files = {p.relative_to(folder).as_posix(): p for p in folder.rglob("*") if p.is_file()}
    mine = [n for n in files if not any(part.startswith(".") for part in Path(n).parts)]
    try:
        for name in sorted(mine, key=lambda name: (name == FILE, name)):
            if name.startswith("manifest.") and name != FILE:
                continue  # the lock and the journal are of this machine
            if (mark := sha256_of(files[name])) != brought.get(name):
                write_remote(f"{url}/{name}", files[name].read_bytes())
                brought[name] = mark
    finally:
        write_atomically(listing, json.dumps(brought).encode())
