"""Write the report on a batch folder, with an overview and a page for each clip."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from functools import partial
from hashlib import sha256
from pathlib import Path, PurePosixPath
from typing import TypeVar

from twistcore.batch.gates import Broken
from twistcore.batch.manifest import ClipRecord, Manifest
from twistcore.errors import TwistError
from twistcore.files.atomic import write_atomically
from twistcore.files.encoding import encode_utf8
from twistcore.files.ordinary import check_no_links, open_to_read, real_path
from twistcore.report.clip_page import Home, clip_page_html
from twistcore.report.document import Report, report_to_json
from twistcore.report.folder_numbers import FolderNumbers, worst_first
from twistcore.report.folder_page import GENERATOR, clip_page_from_manifest, folder_page_html
from twistcore.report.picture_job import NOT_INSTALLED, Drawn, Figure, draw_figures
from twistcore.report.recorded_clip import clip_report_from_batch_record
from twistcore.report.worst_finds import worst_intervals_figure
from twistcore.work.processes import describe_failure, map_in_processes
from twistcore.work.progress import Counter, silent_clip_progress

Made = TypeVar("Made")

INDEX = "index.html"
_TOGETHER = 12  # clips per drawing process, since starting a process takes longer than drawing
_LONGEST = 250  # maximum length in bytes of a name without its suffix
_HEAD = 2048  # bytes at the start of a page that contain the name of its generator


@dataclass(frozen=True)
class FolderReport:
    """The result of writing a report.

    Attributes
    ----------
    index
        Path of the overview.
    pages
        Number of clip pages.
    problems
        The reasons why pages are incomplete.
    """

    index: Path
    pages: int
    problems: tuple[str, ...]


def write_folder_report(
    folder: Path,
    target: Path,
    *,
    workers: int = 1,
    pictures: bool = True,
    play: bool = False,
    most_pages: int | None = None,
    broken: Sequence[Broken] = (),
    records: Sequence[ClipRecord] | None = None,
    changed: Collection[str] | None = None,
    counter: Counter = silent_clip_progress,
) -> FolderReport:
    """Write index.html and clips/NAME.html into a folder.

    The page of a clip that can no longer be read has only the data of the manifest.

    Parameters
    ----------
    folder
        The batch folder.
    target
        The folder to write into, which is created if missing.
    workers
        Number of processes.
    pictures
        True to draw pictures.
    play
        True for pages with pictures that also play their intervals, with up to 3 MB each.
    most_pages
        The maximum number of clips with a page. The worst clips are chosen.
    broken
        The rules of `--fail-if` that the batch has broken.
    records
        Records to use instead of those in the folder's manifest.
    changed
        Names of clips. If given, existing pages of all other clips are kept.
    counter
        A function that shows the progress, as in :mod:`twistcore.work.progress`.

    Raises
    ------
    TwistError
        If there is no manifest, or if a page would replace a file of another program.
    OSError
        If a page cannot be written.
    """
    if records is None:
        with Manifest.open(folder) as manifest:
            records = manifest.records()
    numbers, by_name = FolderNumbers(), {record.name: record for record in records}
    rows = worst_first([numbers.add(record) for record in records])
    with_page = [row.name for row in rows if row.state == "done"][:most_pages]
    pages = {name: clip_page_path(name) for name in with_page}
    for path in (INDEX, *pages.values()):
        if target.is_relative_to(folder):
            check_no_links(folder, target / path)
        _check_ours(target / path)
    home = f"{numbers.clips} clip{'' if numbers.clips == 1 else 's'}"
    if changed is not None:
        with_page = [n for n in with_page if n in changed or not (target / pages[n]).is_file()]
    chunks = [with_page[k : k + _TOGETHER] for k in range(0, len(with_page), _TOGETHER)]
    tasks = [tuple(by_name[name] for name in chunk) for chunk in chunks]
    work = partial(
        _write_pages, folder=folder, target=target, home=home, pictures=pictures, play=play
    )
    problems: list[str] = []
    with counter(len(with_page)) as tell:
        for task, ended in map_in_processes(work, tasks, workers):
            if isinstance(ended, Exception):
                if isinstance(ended, OSError):  # a full disk also affects the next page
                    raise ended
                why = [describe_failure(record.name, ended) for record in task]
                ended = [_write_known(r, target, home, w) for r, w in zip(task, why, strict=True)]
            problems += [problem for problem in ended if problem]
            for record in task:
                tell(record.name)
    rows = [replace(row, page=pages.get(row.name, "")) for row in rows]
    index = target / INDEX
    _write(index, folder_page_html(real_path(folder).name, rows, numbers, broken))
    return FolderReport(index, len(pages), tuple(problems))


def clip_page_path(name: str) -> str:
    """Return the path of a clip's page within the report, with '/' as separator.

    If the clip's name is too long for a file name, it is shortened, and a hash of the full name is
    added.
    """
    parts = [part for part in PurePosixPath(name).parts if part not in ("/", "..", ".")]
    if parts and len(encode_utf8(parts[-1])) > _LONGEST:
        parts[-1] = f"{parts[-1][:50]}-{sha256(encode_utf8(name)).hexdigest()[:16]}"
    return "/".join(["clips", *parts]) + ".html"


# -- pages of clips --------------------------------------------------------------------------------


def _write_pages(
    records: Sequence[ClipRecord],
    *,
    folder: Path,
    target: Path,
    home: str,
    pictures: bool,
    play: bool,
) -> list[str]:
    """Write the pages of some clips. Return the reason why each page is incomplete, or ''.

    `home` is the text of the link to the overview.
    """
    reports = [_read_again(record, folder) for record in records]
    figures: list[Figure | None] = [
        worst_intervals_figure(report, play) if isinstance(report, Report) and pictures else None
        for report in reports
    ]
    drawn = _drawn(figures)
    problems = []
    for record, report, pair in zip(records, reports, drawn, strict=True):
        if isinstance(report, Report):
            made = _tried(partial(_page, record, report, pair if pictures else None, home))
            if not isinstance(made, Exception):
                _write(target / clip_page_path(record.name), made)
                # If the window is not installed, the pages mention it, and it is not a problem.
                why = "" if pair.problem == NOT_INSTALLED else pair.problem
                problems.append(why and f"{record.name}: no pictures: {why}")
                continue
            report = made
        problems.append(_write_known(record, target, home, describe_failure(record.name, report)))
    return problems


def _read_again(record: ClipRecord, folder: Path) -> Report | Exception:
    return _tried(partial(clip_report_from_batch_record, record, folder))


def _tried(make: Callable[[], Made]) -> Made | Exception:
    try:
        return make()
    except Exception as error:  # a clip that cannot be reported must not stop the others
        return error


def _drawn(figures: Sequence[Figure | None]) -> list[Drawn]:
    """Draw the figures. For each figure, return its pictures, or an empty result for None."""
    pictured = iter(draw_figures([figure for figure in figures if figure is not None]))
    return [Drawn() if figure is None else next(pictured) for figure in figures]


def _page(record: ClipRecord, report: Report, drawn: Drawn | None, home: str) -> str:
    document = {**report_to_json(report), "clip": record.name}
    return clip_page_html(document, report, drawn, _home(record, home))


def _write_known(record: ClipRecord, target: Path, home: str, why: str) -> str:
    """Write a page with only the manifest's data and the reason, `why`. Return `why`."""
    _write(
        target / clip_page_path(record.name),
        clip_page_from_manifest(record, why, _home(record, home)),
    )
    return why


def _home(record: ClipRecord, title: str) -> Home:
    return Home(title, "../" * clip_page_path(record.name).count("/") + INDEX)


def _write(path: Path, page: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, encode_utf8(page))


def _check_ours(path: Path) -> None:
    """Raise TwistError if the page would replace a file that this program did not write."""
    try:
        with open_to_read(path) as file:
            head = file.read(_HEAD)
    except (FileNotFoundError, NotADirectoryError):
        return
    except OSError as error:
        raise TwistError(f"{path}: the report cannot be written ({error.strerror})") from None
    if GENERATOR.encode() not in head:
        raise TwistError(
            f"{path} already exists and is not a report of this program; move the file, or "
            "choose another folder for the report"
        )
