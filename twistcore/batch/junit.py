"""Write the results of a batch as JUnit XML, a format for test results in continuous integration.

There is a test case for each clip, and one for each rule for the whole run. Since JUnit XML has no
single standard, only elements and attributes that common readers support are used. A case has at
most one failure, because some readers show only the first one.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Sequence
from pathlib import Path, PurePosixPath
from xml.etree import ElementTree

from twistcore.analysis.clip_severity import unexamined_limb_sentences
from twistcore.batch.gates import Broken, Rule
from twistcore.batch.manifest import ClipRecord
from twistcore.files.atomic import write_atomically
from twistcore.files.encoding import escape_invalid_utf8

_NOT_XML = re.compile(r"[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # in XML 1.0
_SUITE = "twistcore batch"


def write_junit(
    path: Path, records: Iterable[ClipRecord], rules: Sequence[Rule], broken: Iterable[Broken]
) -> None:
    """Write the results of a batch to a file as JUnit XML. Raises OSError.

    The other parameters are the same as for :func:`junit_xml`.
    """
    write_atomically(path, junit_xml(records, rules, broken))


def junit_xml(
    records: Iterable[ClipRecord], rules: Sequence[Rule], broken: Iterable[Broken]
) -> bytes:
    """Return the results of a batch as JUnit XML in UTF-8.

    A clip is a failure if it breaks a rule, an error if it could not be processed or examined, and
    skipped if it has not been processed yet. The output of a test case lists limbs that were not
    examined. Characters that XML does not allow are written as escapes.

    Parameters
    ----------
    records
        The clips.
    rules
        All requested rules.
    broken
        The broken rules, from :func:`twistcore.batch.gates.broken_rules`.
    """
    by_clip: dict[str, list[Broken]] = defaultdict(list)
    for one in broken:
        by_clip[one.clip].append(one)
    suite = ElementTree.Element("testsuite", name=_SUITE)
    seconds = 0.0
    for record in records:
        case = _case(suite, record.name, record.seconds)
        seconds += record.seconds
        if record.state == "failed":
            _ending(case, "error", "could not be processed", [record.reason])
        elif record.state != "done":
            ElementTree.SubElement(case, "skipped", message="not processed yet")
        elif by_clip[record.name]:
            _fails(case, by_clip[record.name])
        elif why := (record.result or {}).get("unchecked"):
            _ending(case, "error", "could not be examined", [why])
        if limbs := unexamined_limb_sentences(record.result or {}):
            ElementTree.SubElement(case, "system-out").text = _legal("\n".join(limbs))
    for rule in (rule for rule in rules if rule.total):
        case = _case(suite, rule.text, 0.0, "total")
        if breaks := [one for one in by_clip[""] if one.rule == rule]:
            _fails(case, breaks)
    counts = {
        "tests": len(suite),
        "failures": len(suite.findall("testcase/failure")),
        "errors": len(suite.findall("testcase/error")),
    }
    root = ElementTree.Element("testsuites", name=_SUITE)
    for element in (suite, root):
        for name, count in counts.items():
            element.set(name, str(count))
        element.set("time", f"{seconds:.3f}")
    suite.set("skipped", str(len(suite.findall("testcase/skipped"))))
    root.append(suite)
    ElementTree.indent(root, " ")
    text: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return text + b"\n"


def _case(
    suite: ElementTree.Element, name: str, seconds: float, of: str = ""
) -> ElementTree.Element:
    """Add a test case to a suite. Its class name is the clip's folder, with dots instead of '/'.

    Readers of JUnit XML group test cases by class name. If `of` is given, it replaces the class
    name.
    """
    folder = of or ".".join(("clips", *PurePosixPath(name).parent.parts))
    return ElementTree.SubElement(
        suite, "testcase", classname=_legal(folder), name=_legal(name), time=f"{seconds:.3f}"
    )


def _fails(case: ElementTree.Element, breaks: Sequence[Broken]) -> None:
    _ending(case, "failure", ", ".join(one.rule.text for one in breaks), map(str, breaks))


def _ending(case: ElementTree.Element, what: str, message: str, lines: Iterable[str]) -> None:
    element = ElementTree.SubElement(case, what, message=_legal(message), type=what)
    element.text = _legal("\n".join(lines))


def _legal(text: str) -> str:
    return _NOT_XML.sub(lambda found: ascii(found[0])[1:-1], escape_invalid_utf8(text))
