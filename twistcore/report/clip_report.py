"""Write the report on a clip: an HTML page, the intervals as CSV, and all data as JSON."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from twistcore.errors import FormatError, TwistError
from twistcore.export.markers import blender_markers
from twistcore.files.atomic import write_atomically
from twistcore.files.document_values import parsed_json
from twistcore.files.encoding import encode_utf8, json_bytes
from twistcore.files.marks import cached_sha256
from twistcore.files.ordinary import is_file, read_file
from twistcore.formats.clip import Clip
from twistcore.formats.reading import companion_file_prefix
from twistcore.report.clip_page import clip_page_html
from twistcore.report.document import SCHEMA, Report, intervals_csv, report_to_json
from twistcore.report.worst_finds import draw_pictures


def write_clip_report(
    folder: Path, report: Report, *, pictures: bool = False, play: bool = False
) -> tuple[Path, ...]:
    """Write the report on a clip into a folder, and return the paths of the files.

    The files are NAME.report.html, NAME.report.json, NAME.intervals.csv, and NAME.markers.py for
    Blender. The JSON lists the SHA-256 of the other files and of the files in `report.files`. While
    the files are being written, it also lists the SHA-256 of the files that they replace, so that
    the next run recognises either version after a crash.

    Parameters
    ----------
    folder
        The folder, which is created if missing.
    report
        The report.
    pictures
        True to draw pictures.
    play
        True for a page with pictures that also plays the intervals.

    Raises
    ------
    TwistError
        If a file would be replaced that must be kept, as in :func:`check_report_replaceable`.
    OSError
        If a file cannot be written.
    """
    name = report.name or companion_file_prefix(report.clip.path)
    check_report_replaceable(folder, name, None if report.name else report.clip)
    folder.mkdir(parents=True, exist_ok=True)
    document = report_to_json(report)
    page, table, markers, last = report_files(folder, name)
    drawn = draw_pictures(report, play) if pictures else None
    written = {
        page: encode_utf8(clip_page_html(document, report, drawn)),
        table: encode_utf8(intervals_csv(report)),
        markers: encode_utf8(
            blender_markers(report.clip.name, report.state.intervals, report.verdict)
        ),
    }
    marks = {path.name: hashlib.sha256(data).hexdigest() for path, data in written.items()}
    document["files"] = {**report.files, **marks}
    replaced = {path.name: cached_sha256(path) for path in written if is_file(path)}
    write_atomically(last, json_bytes(document | {"replaced": replaced}))
    for path, data in written.items():
        write_atomically(path, data)
    write_atomically(last, json_bytes(document))
    return (*written, last)


def check_report_replaceable(folder: Path, name: str, clip: Clip | None = None) -> None:
    """Raise TwistError if a report would replace another program's file or another clip's report.

    `clip` is the reported clip. If it is None, the report of another clip may be replaced. A clip
    with the same name but other bytes counts as a new version of the reported clip.
    """
    *others, listing = report_files(folder, name)
    marks = read_report_hashes(listing)
    for path in others:
        if path.is_dir() or (is_file(path) and cached_sha256(path) not in marks.get(path.name, ())):
            raise TwistError(
                f"{path} already exists, but was not written by this version or has been "
                "changed since; move that file, or leave the report out"
            )
    if is_file(listing) and not marks:
        raise TwistError(
            f"{listing} already exists and is not a report; move that file, or leave the report out"
        )
    if clip is not None and (of := _other_clip(listing, clip)):
        raise TwistError(
            f"{listing} already exists and is the report of {of}; choose another folder for "
            f"the report of {clip.name}"
        )


def _other_clip(listing: Path, clip: Clip) -> str:
    """Return the name of the clip that an existing report is about, or '' if that is `clip`."""
    document = read_report_json(listing)
    of, mark = (str(document.get(key, "")) for key in ("clip", "sha256"))
    return of if of != clip.name and mark != clip.sha256 else ""


def has_report_on_different_clip(folder: Path, name: str, clip: Clip) -> bool:
    """Return True if the existing report is about a file with the clip's name but other bytes.

    That file may be an earlier version of the clip or a clip from another folder. The two cases
    cannot be distinguished.
    """
    mark = read_report_json(report_files(folder, name)[-1]).get("sha256")
    return mark is not None and mark != clip.sha256


def report_files(folder: Path, name: str) -> tuple[Path, ...]:
    """Return the paths of the HTML, CSV, markers and JSON files of a report, in this order."""
    endings = ("report.html", "intervals.csv", "markers.py", "report.json")
    return tuple(folder / f"{name}.{ending}" for ending in endings)


def read_report_hashes(listing: Path) -> dict[str, tuple[object, ...]]:
    """Return the SHA-256 values that a report's JSON lists, keyed by file name.

    A file that is being replaced has two values. Names and values are not checked. The result is
    empty if the JSON is missing or is not a report. Raises TwistError if it cannot be read.
    """
    document = read_report_json(listing)
    try:
        new, old = dict(document.get("files", {})), dict(document.get("replaced", {}))
    except (ValueError, TypeError):
        return {}
    return {name: tuple(of[name] for of in (new, old) if name in of) for name in new | old}


def read_report_json(listing: Path) -> dict[str, Any]:
    """Return the contents of a report's JSON, or {} if it is missing or not a report.

    Raises TwistError if it cannot be read.
    """
    try:
        document = parsed_json(read_file(listing))
        return dict(document) if document["schema"] == SCHEMA else {}
    except (FileNotFoundError, FormatError, KeyError, TypeError):
        return {}
    except OSError as error:
        raise TwistError(f"{listing}: cannot be read ({error.strerror})") from None
