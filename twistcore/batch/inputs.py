"""Find clips that a user specifies as files, folders, patterns, lists or URLs, and name them."""

from __future__ import annotations

import glob
import os
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatch
from pathlib import Path, PurePosixPath

from twistcore.batch.clip_task import file_change_signature
from twistcore.batch.manifest import FILE, is_batch_folder
from twistcore.errors import TwistError
from twistcore.export.exported_clips import find_exports_in_folder
from twistcore.files.ordinary import read_file
from twistcore.formats.suffixes import CLIP_SUFFIXES, known_formats
from twistcore.work.frozen import dataclass


@dataclass(frozen=True)
class Source:
    """A clip to process.

    Parameters
    ----------
    path
        Absolute path or URL.
    name
        A unique path relative to the given folder, with '/'.
    size
        Size in bytes, 0 if unknown.
    signature
        The file's signature from `clip_task.file_change_signature`, '' if unknown.
    settled
        True if the signature is reliable, which means that any change to the file changes it.
    """

    path: str
    name: str
    size: int = 0
    signature: str = ""
    settled: bool = False


@dataclass(frozen=True)
class Inputs:
    """The clips that a user has specified.

    Parameters
    ----------
    sources
        The clips, in the order of the inputs.
    problems
        A sentence for each input without clips.
    exports
        Number of files that were skipped because this program exported them from other clips in the
        same folder.
    """

    sources: tuple[Source, ...]
    problems: tuple[str, ...]
    exports: int = 0


def find_input_clips(
    words: Iterable[str], without: Path | None = None, *, may_be_none: bool = False
) -> Inputs:
    """Return the clips to which some words, such as command-line arguments, refer.

    Each word is one of the following:

    - a file with any suffix
    - a folder, for the clips in it and its subfolders, except hidden folders and batch folders
    - a pattern with `*`, `?` or `[ ]`, in which `**` matches folders with the same exceptions
    - '@FILE' for a list with one word per line, or '@-' or '-' for a list on standard input
    - the URL of a file or folder

    In local folders and patterns, files that this program exported from other clips are skipped
    (see `exported_clips.exclude_previously_exported_clips`).

    Parameters
    ----------
    words
        The words, each in one of the forms listed above.
    without
        A folder to exclude from the search, usually the output folder.
    may_be_none
        True to return an empty result, instead of raising an error, if there are no clips.

    Raises
    ------
    TwistError
        If a word refers to something in `without`, a list cannot be read, or there is no clip.
    """
    found: dict[str, Source] = {}
    problems: list[str] = []
    files: list[str] = []
    exports: set[str] = set()
    for word in _expanded(words):
        if without is not None and "://" not in word and _is_in(word, without):
            raise TwistError(
                f"{word}: expected clips outside {without}, the folder for the results"
            )
        group = list(_of_word(word, without, files))
        if not group and word not in files:
            problems.append(
                f"{word}: expected a clip, a folder with clips, or a pattern that matches clips"
            )
        left_out = set() if "://" in word else _exports_among(group)
        exports |= left_out
        for source in group:
            if source.path not in left_out:
                found.setdefault(source.path, source)
    for source in _of_files(files):
        found.setdefault(source.path, source)
    if not (found or may_be_none):
        raise TwistError(problems[0] if problems else "expected clips, but the list is empty")
    return Inputs(
        tuple(_with_unique_names(found.values())), tuple(problems), len(exports - found.keys())
    )


def assign_batch_names(sources: Iterable[Source], names: Mapping[str, str]) -> list[Source]:
    """Return the sources with the names that they have in a batch, or with new, unique names.

    `names` maps the path of each clip in the batch to its name. Clips that are already in the batch
    come first in the result.
    """
    known: list[Source] = []
    new: list[Source] = []
    for source in sources:
        (known if source.path in names else new).append(source)
    taken = {name.casefold() for name in names.values()}
    kept = [replace(source, name=names[source.path]) for source in known]
    return kept + list(_with_unique_names(new, taken))


def has_clip_suffix(name: str) -> bool:
    """Return True if a file name has the suffix of a clip, in upper or lower case."""
    return os.path.splitext(name)[1].lower() in CLIP_SUFFIXES  # noqa: PTH122 of a million names


def _expanded(words: Iterable[str]) -> Iterator[str]:
    """Yield the words, with each '@FILE', '@-' or '-' replaced by the lines of that list."""
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
    """Yield the non-empty lines of a list, without the byte order mark that Windows adds."""
    lines = text.removeprefix("\ufeff").removeprefix("\udcef\udcbb\udcbf").splitlines()
    return (line.strip() for line in lines if line.strip())


def _of_word(word: str, without: Path | None, files: list[str]) -> Iterator[Source]:
    """Yield the clips of a folder, pattern or URL. Append any other word to the list `files`."""
    if "://" in word:
        from twistcore.files.remote_files import list_remote_files

        for path, name, size in list_remote_files(word):
            # Only a download could show whether a pickle has poses, so it must be named explicitly.
            if path == word or (has_clip_suffix(name) and not name.lower().endswith(".pkl")):
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
    """Yield the clips in a folder and its subfolders whose relative names `fits` accepts.

    `fits` is called with the path of each file relative to `root`. Symbolic links to folders are
    not followed.
    """
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
            # A link may lead to a folder. Making a Path for each of many files would be slow.
            elif has_clip_suffix(entry.name) and not os.path.isdir(entry.path):  # noqa: PTH112
                name = os.path.relpath(entry.path, root).replace(os.sep, "/")
                if fits(name) and not _has_other_data(entry.path):
                    yield _source(entry.path, name)
        folders += reversed(below)


def _matching(pattern: str, without: Path | None) -> Iterator[Source]:
    """Yield the clips that match a pattern, and the clips in folders that match it.

    Clips are named by their paths relative to the last folder before the first wildcard.
    """
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
            if rest and _is_skipped(path, root):
                continue
            for source in _below(path, without, lambda name: _fits(name.split("/"), rest)):
                name = (path.relative_to(root) / source.name).as_posix()
                yield replace(source, name=name)
        elif rest:
            continue
        elif (
            has_clip_suffix(found)
            and not (without and _is_in(path, without))
            and not _has_other_data(found)
        ):
            yield _source(str(path), path.relative_to(root).as_posix())


def _fits(names: Sequence[str], parts: Sequence[str]) -> bool:
    """Return True if the components of a path match those of a pattern, which may contain '**'.

    An empty pattern matches every path.
    """
    if not parts:
        return True
    if parts[0] == "**":
        return any(_fits(names[k:], parts[1:]) for k in range(len(names)))
    fit = bool(names) and fnmatch(names[0], parts[0])
    return fit and (_fits(names[1:], parts[1:]) if parts[1:] else len(names) == 1)


def _is_skipped(folder: Path, root: Path) -> bool:
    """Return True if `folder`, or a folder between `root` and it, is a link or a batch folder."""
    way = [folder, *folder.parents]
    return any(step.is_symlink() or is_batch_folder(step) for step in way[: way.index(root)])


def _has_other_data(path: str) -> bool:
    """Return True if a file has a clip's suffix but no motion, such as a body shape from AMASS."""
    known = known_formats().get(os.path.splitext(path)[1].lower())  # noqa: PTH122
    if known is None or not known.without_motion:
        return False
    from twistcore.formats.reading import is_clip_without_motion  # numpy

    return is_clip_without_motion(path)


def _exports_among(sources: Iterable[Source]) -> set[str]:
    """Return the paths of the sources that are exports of other clips in the same folder."""
    folders: dict[str, list[str]] = defaultdict(list)
    for source in sources:
        folder, name = os.path.split(source.path)
        folders[folder].append(name)
    return {
        os.path.join(folder, name)  # noqa: PTH118
        for folder, names in folders.items()
        for name in find_exports_in_folder(folder, names)
    }


def _is_in(path: Path | str, folder: Path) -> bool:
    return Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))


def _of_files(files: Iterable[str]) -> Iterator[Source]:
    """Yield a clip for each file, named by its path relative to the common folder of all files."""
    paths = [os.path.abspath(file) for file in files]  # noqa: PTH100
    if not paths:
        return
    try:
        root = os.path.commonpath([os.path.dirname(path) for path in paths])  # noqa: PTH120
    except ValueError:  # on different drives
        root = ""
    for path in paths:
        name = os.path.relpath(path, root) if root else os.path.basename(path)  # noqa: PTH119
        yield _source(path, name.replace(os.sep, "/"))


def _source(path: str, name: str) -> Source:
    try:
        signature, settled = file_change_signature(path)
    except OSError:  # missing, or a broken link: reading it reports the error
        return Source(path, name)
    return Source(path, name, int(signature.partition(" ")[0]), signature, settled)


def _with_unique_names(sources: Iterable[Source], taken: Iterable[str] = ()) -> Iterator[Source]:
    """Yield the sources with names that are unique even if case is ignored.

    A repeated name is prefixed with the name of the clip's folder. If it is still not unique, a
    number is added. `taken` contains names that are already in use, in lower case.
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
    """Return the name of the folder to which a source's name is relative."""
    parts = PurePosixPath(source.path.replace(os.sep, "/")).parts
    above = parts[: len(parts) - len(PurePosixPath(source.name).parts)]
    return above[-1] if above and above[-1] not in ("/", "\\") else "other"
