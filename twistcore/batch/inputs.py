"""Which clips are meant: files, folders with all below, patterns, lists, URLs; each with a name."""

from __future__ import annotations

import glob
import os
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatch
from pathlib import Path, PurePosixPath

from twistcore.batch.clip_task import signature_of
from twistcore.batch.manifest import FILE, is_batch_folder
from twistcore.errors import TwistError
from twistcore.export.exports_beside import exports_in
from twistcore.files.ordinary import read_file
from twistcore.formats.suffixes import CLIP_SUFFIXES, known_formats
from twistcore.work.frozen import dataclass


@dataclass(frozen=True)
class Source:
    """A clip that is meant.

    path: absolute, or a URL; name: below its input, with '/', unique among all; size: bytes, 0 if
    unknown; signature: see `clip_task.signature_of`, '' if unknown; settled: whether a change
    since would show in that.
    """

    path: str
    name: str
    size: int = 0
    signature: str = ""
    settled: bool = False


@dataclass(frozen=True)
class Inputs:
    """The clips, in the order of what was asked for, and a sentence for each that found none.

    exports: how many files were left out, as this program wrote them of clips beside them.
    """

    sources: tuple[Source, ...]
    problems: tuple[str, ...]
    exports: int = 0


def find_inputs(words: Iterable[str], without: Path | None = None) -> Inputs:
    """The clips that words mean.

    A word is a file (of any suffix), a folder (its clips, and those of all folders below, but for
    hidden ones and for folders that a batch has written), a pattern with *, ? or [ ], in which **
    goes over folders with the same exceptions, '@FILE' for a list with a word a line, '@-' or
    '-' for one on standard input, or a URL of a file or folder. Of a folder or a pattern on this
    machine those are left out that are exports of others of it:
    `exports_beside.exports_among`. without: a folder that is left out, where it lies below
    another. TwistError where something in that is named itself, a list cannot be read, or there is
    no clip at all.
    """
    found: dict[str, Source] = {}
    problems: list[str] = []
    files: list[str] = []
    exports: set[str] = set()
    for word in _spelled_out(words):
        if without is not None and "://" not in word and _is_in(word, without):
            raise TwistError(f"{word}: expected clips outside {without}, the folder to write into")
        group = list(_of_word(word, without, files))
        if not group and word not in files:
            problems.append(f"{word}: expected a clip, or a folder or pattern with clips")
        left_out = set() if "://" in word else _exports_among(group)
        exports |= left_out
        for source in group:
            if source.path not in left_out:
                found.setdefault(source.path, source)
    for source in _of_files(files):
        found.setdefault(source.path, source)
    if not found:
        raise TwistError(problems[0] if problems else "expected clips, found an empty list")
    return Inputs(tuple(_named_apart(found.values())), tuple(problems), len(exports - found.keys()))


def renamed(sources: Iterable[Source], names: Mapping[str, str]) -> list[Source]:
    """The same with names that are theirs already, by path; the others' avoid these."""
    known: list[Source] = []
    new: list[Source] = []
    for source in sources:
        (known if source.path in names else new).append(source)
    taken = {name.casefold() for name in names.values()}
    kept = [replace(source, name=names[source.path]) for source in known]
    return kept + list(_named_apart(new, taken))


def is_clip_name(name: str) -> bool:
    """By its suffix, in any case."""
    return os.path.splitext(name)[1].lower() in CLIP_SUFFIXES  # noqa: PTH122 of a million names


def _spelled_out(words: Iterable[str]) -> Iterator[str]:
    """With the lines of lists in their places."""
    for word in words:
        if word in ("-", "@-"):
            yield from _lines(sys.stdin.read())
        elif word.startswith("@"):
            try:
                text = read_file(word[1:]).decode("utf-8", "surrogateescape").removeprefix("\ufeff")
            except OSError as error:
                raise TwistError(f"{word[1:]}: cannot be read ({error.strerror})") from None
            yield from _lines(text)
        else:
            yield word


def _lines(text: str) -> Iterator[str]:
    """Not empty, without the mark that Windows puts in front of UTF-8."""
    lines = text.removeprefix("\ufeff").removeprefix("\udcef\udcbb\udcbf").splitlines()
    return (line.strip() for line in lines if line.strip())


def _of_word(word: str, without: Path | None, files: list[str]) -> Iterator[Source]:
    """Clips of a folder, a pattern or a URL; a file is put to the others instead."""
    if "://" in word:
        from twistcore.batch.remote_files import find_remote

        for path, name, size in find_remote(word):
            # Whether a pickle there has poses would take reading it: one is named itself.
            if path == word or (is_clip_name(name) and not name.lower().endswith(".pkl")):
                yield Source(path, name, size)
    elif os.path.isdir(word):  # noqa: PTH112
        yield from _below(Path(os.path.abspath(word)), without)  # noqa: PTH100
    elif glob.has_magic(word) and not os.path.lexists(word):
        yield from _matching(word, without)
    else:
        files.append(word)


def _below(
    root: Path, without: Path | None, fits: Callable[[str], bool] = lambda _name: True
) -> Iterator[Source]:
    """The clips of a folder and of all below whose names fit; links to folders are not followed."""
    skipped = None if without is None else os.path.realpath(without)
    folders = [str(root)]
    while folders:
        folder = folders.pop()
        if os.path.realpath(folder) == skipped:
            continue
        try:
            entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
        except OSError as error:
            raise TwistError(f"{folder}: cannot be read ({error.strerror})") from None
        if folder != str(root) and any(e.name == FILE for e in entries) and is_batch_folder(folder):
            continue
        below = []
        for entry in entries:
            if entry.name.startswith("."):
                continue
            if entry.is_dir(follow_symlinks=False):
                below.append(entry.path)
            elif is_clip_name(entry.name) and not os.path.isdir(entry.path):  # noqa: PTH112
                name = os.path.relpath(entry.path, root).replace(os.sep, "/")
                if fits(name) and not _other(entry.path):
                    yield _looked_at(entry.path, name)
        folders += reversed(below)


def _matching(pattern: str, without: Path | None) -> Iterator[Source]:
    """Clips and folders that a pattern fits; names are from its first part with a sign on."""
    parts = Path(pattern).parts
    at = next(k for k, part in enumerate(parts) if glob.has_magic(part))
    root = Path(os.path.abspath(Path(*parts[:at]) if at else "."))  # noqa: PTH100
    over = parts.index("**") if "**" in parts else len(parts)
    rest = parts[over:]
    if over == at:
        hits = [str(root)]
    else:
        hits = sorted(glob.glob(str(Path(*parts[:over]))))  # noqa: PTH207 of any folder
    for found in hits:
        path = Path(os.path.abspath(found))  # noqa: PTH100
        if path.is_dir():
            if rest and _is_passed_over(path, root):
                continue
            for source in _below(path, without, lambda name: _fits(name.split("/"), rest)):
                name = (path.relative_to(root) / source.name).as_posix()
                yield replace(source, name=name)
        elif rest:
            continue
        elif is_clip_name(found) and not (without and _is_in(path, without)) and not _other(found):
            yield _looked_at(str(path), path.relative_to(root).as_posix())


def _fits(names: Sequence[str], parts: Sequence[str]) -> bool:
    """Whether folders and a file at the end fit the parts of a pattern; none of these fit all."""
    if not parts:
        return True
    if parts[0] == "**":
        return any(_fits(names[k:], parts[1:]) for k in range(len(names)))
    fit = bool(names) and fnmatch(names[0], parts[0])
    return fit and (_fits(names[1:], parts[1:]) if parts[1:] else len(names) == 1)


def _is_passed_over(folder: Path, root: Path) -> bool:
    """Whether a way from a folder down to another goes over a link or what a batch has written."""
    way = [folder, *folder.parents]
    return any(step.is_symlink() or is_batch_folder(step) for step in way[: way.index(root)])


def _other(path: str) -> bool:
    """Whether what has a clip's name holds something else: bodies' shapes lie beside AMASS's."""
    known = known_formats().get(os.path.splitext(path)[1].lower())  # noqa: PTH122
    if known is None or not known.without_motion:
        return False
    from twistcore.formats.reading import is_other_data  # numpy

    return is_other_data(path)


def _exports_among(sources: Iterable[Source]) -> set[str]:
    """The paths of those that are exports of others in the same folder."""
    folders: dict[str, list[str]] = defaultdict(list)
    for source in sources:
        folder, name = os.path.split(source.path)
        folders[folder].append(name)
    return {
        os.path.join(folder, name)  # noqa: PTH118
        for folder, names in folders.items()
        for name in exports_in(folder, names)
    }


def _is_in(path: Path | str, folder: Path) -> bool:
    return Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))


def _of_files(files: Iterable[str]) -> Iterator[Source]:
    """Files that were named one by one, there or not; names are from their common folder on."""
    paths = [os.path.abspath(file) for file in files]  # noqa: PTH100
    if not paths:
        return
    try:
        root = os.path.commonpath([os.path.dirname(path) for path in paths])  # noqa: PTH120
    except ValueError:  # of several drives
        root = ""
    for path in paths:
        name = os.path.relpath(path, root) if root else os.path.basename(path)  # noqa: PTH119
        yield _looked_at(path, name.replace(os.sep, "/"))


def _looked_at(path: str, name: str) -> Source:
    try:
        signature, settled = signature_of(path)
    except OSError:  # gone, or a link astray: who reads it says so
        return Source(path, name)
    return Source(path, name, int(signature.partition(" ")[0]), signature, settled)


def _named_apart(sources: Iterable[Source], taken: Iterable[str] = ()) -> Iterator[Source]:
    """With names that differ, also where a disk takes 'A' for 'a'.

    A second of a name gets its folder's in front, or a number behind its stem.
    """
    used = set(taken)
    for source in sources:
        name = source.name
        if name.casefold() in used:
            name = PurePosixPath(_folder_name(source), name).as_posix()
        plain, number = PurePosixPath(name), 2
        while name.casefold() in used:
            name = plain.with_name(f"{plain.stem}-{number}{plain.suffix}").as_posix()
            number += 1
        used.add(name.casefold())
        yield replace(source, name=name)


def _folder_name(source: Source) -> str:
    """The name of the folder that a source's name begins in."""
    parts = PurePosixPath(source.path.replace(os.sep, "/")).parts
    above = parts[: len(parts) - len(PurePosixPath(source.name).parts)]
    return above[-1] if above and above[-1] not in ("/", "\\") else "other"
