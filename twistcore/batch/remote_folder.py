"""Provide the working folder of a batch: a local folder, a temporary one, or a local copy of a URL.

If the folder is a copy, its files are uploaded to the URL at the end.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import platformdirs

from twistcore.batch.manifest import FILE
from twistcore.batch.run import LOCK
from twistcore.errors import TwistError
from twistcore.files.atomic import write_atomically
from twistcore.files.lock import is_file_locked
from twistcore.files.marks import sha256_of
from twistcore.files.ordinary import user_folder_or_uncreatable_path
from twistcore.files.remote_files import list_remote_files, read_remote_file, write_remote_file

_UPLOADED = ".uploaded.json"  # SHA-256 of the files at the URL, keyed by relative path


@contextmanager
def synchronised_batch_folder(output: str) -> Iterator[Path]:
    """Yield a local folder for a batch, which is uploaded at the end if `output` is a URL.

    If `output` is '', the folder is temporary. For a URL, the folder initially contains a copy of
    the files at the URL. Only changed files are uploaded, and the manifest last, so that it never
    lists missing files. If a run is killed, the next run on this machine uploads its results.
    Raises TwistError if the URL cannot be read or written.
    """
    if not output:
        with TemporaryDirectory() as temporary:
            yield Path(temporary)
        return
    if "://" not in output:
        yield Path(output)
        return
    url = output.rstrip("/")
    name = hashlib.sha256(url.encode()).hexdigest()[:16]
    folder = (
        user_folder_or_uncreatable_path(partial(platformdirs.user_cache_path, "twist-inspector"))
        / "batch"
        / name
    )
    folder.mkdir(parents=True, exist_ok=True)
    if not is_file_locked(folder / LOCK):  # run_batch reports a lock
        _take_over(url, folder)
    try:
        yield folder
    finally:
        if not is_file_locked(folder / LOCK):
            _upload(folder, url)


def _take_over(url: str, folder: Path) -> None:
    """Download the files at a URL if another machine has changed them since the last upload.

    Raises TwistError if the local folder has also changed since the last upload.
    """
    there = {name: path for path, name, _ in list_remote_files(url, may_be_none=True)}
    if FILE not in there:
        return
    if (folder / FILE).exists():
        mark = hashlib.sha256(read_remote_file(there[FILE])).hexdigest()
        own, last = sha256_of(folder / FILE), _uploaded(folder).get(FILE)
        if mark in (own, last):
            return
        if own != last:
            raise TwistError(
                f"{url}: another machine has written to this folder since the run on this "
                f"machine stopped; remove {folder} to continue from the other machine's "
                "results"
            )
    _download(there, folder)


def _download(there: Mapping[str, str], folder: Path) -> None:
    """Download the files of a batch, with the manifest last. `there` maps file names to URLs."""
    uploaded = {}
    for name in sorted(there, key=lambda name: name == FILE):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        write_atomically(path, read_remote_file(there[name]))
        uploaded[name] = sha256_of(path)
    write_atomically(folder / _UPLOADED, json.dumps(uploaded).encode())


def _uploaded(folder: Path) -> dict[str, str]:
    listing = folder / _UPLOADED
    found: dict[str, str] = json.loads(listing.read_text("utf-8")) if listing.exists() else {}
    return found


def _upload(folder: Path, url: str) -> None:
    listing, uploaded = folder / _UPLOADED, _uploaded(folder)
    files = {p.relative_to(folder).as_posix(): p for p in folder.rglob("*") if p.is_file()}
    mine = [n for n in files if not any(part.startswith(".") for part in Path(n).parts)]
    try:
        for name in sorted(mine, key=lambda name: (name == FILE, name)):
            if name.startswith("manifest.") and name != FILE:
                continue  # the lock and the journal are only for this machine
            if (mark := sha256_of(files[name])) != uploaded.get(name):
                write_remote_file(f"{url}/{name}", files[name].read_bytes())
                uploaded[name] = mark
    finally:
        write_atomically(listing, json.dumps(uploaded).encode())
