"""Write the problems of a batch as annotations, which GitHub shows in a pull request.

GitHub shows them next to the affected files. An annotation is a line `::error file=…,title=…::…` in
the output of a workflow step.
"""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

from twistcore.batch.gates import Broken
from twistcore.batch.manifest import ClipRecord
from twistcore.files.atomic import write_atomically
from twistcore.files.encoding import escape_control_characters


def write_annotations(path: Path, records: Iterable[ClipRecord], broken: Iterable[Broken]) -> None:
    """Write the annotation lines of a batch, from :func:`github_annotations`, to a file.

    Clips are named by their paths relative to the current folder. Raises OSError.
    """
    write_atomically(path, github_annotations(records, broken, str(Path.cwd())).encode())


def github_annotations(records: Iterable[ClipRecord], broken: Iterable[Broken], root: str) -> str:
    r"""Return one annotation line per problematic clip, and one per broken rule of the whole run.

    A clip is problematic if it breaks a rule or could not be processed or examined. Clips inside
    the folder `root` are named by their paths relative to it. For all other clips, the line has no
    file name. Control characters such as `\x1b` are escaped.
    """
    of_run: list[Broken] = []
    by_clip: dict[str, list[Broken]] = defaultdict(list)
    for one in broken:
        (by_clip[one.clip] if one.clip else of_run).append(one)
    lines = []
    for record in records:
        breaks = by_clip[record.name]
        if record.state == "failed":
            lines.append(_error("could not be processed", record.reason, record.source, root))
        elif breaks:
            rules = ", ".join(one.rule.text for one in breaks)
            lines.append(_error(rules, "\n".join(map(str, breaks)), record.source, root))
        elif why := (record.result or {}).get("unchecked"):
            text = f"{record.name}: {why}"
            lines.append(_error("could not be examined", text, record.source, root))
    lines += [_error(one.rule.text, str(one)) for one in of_run]
    return "".join(f"{line}\n" for line in lines)


def _error(title: str, text: str, source: str = "", root: str = "") -> str:
    named = [f"title={_value(title)}"]
    if source and "://" not in source and Path(source).is_relative_to(root):
        name = os.path.relpath(source, root).replace(os.sep, "/")
        named.insert(0, f"file={_value(name)}")
    return f"::error {','.join(named)}::{_data(text)}"


def _value(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")


def _data(text: str) -> str:
    return escape_control_characters(
        text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")
    )
