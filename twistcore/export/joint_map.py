"""Read new joint names from a file, or find the names in a known naming scheme."""

from __future__ import annotations

import codecs
import csv
from collections.abc import Mapping
from pathlib import Path

from twistcore.errors import FormatError
from twistcore.files.document_values import (
    check_keys,
    check_string,
    parsed_json,
    prefix_format_errors,
    read_bytes_limited,
)
from twistcore.formats.smpl.skeleton import CMU_NAMES, SMPL_NAMES
from twistcore.skeleton.body import find_body
from twistcore.skeleton.motion import Motion


def read_joint_names_for_export(path: Path) -> Mapping[str, str]:
    """Read new joint names, keyed by old name, from a JSON object or a CSV with two columns.

    Raises FormatError if the file is neither, and TwistError if it cannot be read.
    """
    data = read_bytes_limited(path).removeprefix(codecs.BOM_UTF8)
    with prefix_format_errors(path):
        if data.lstrip()[:1] in (b"{", b"["):
            document = check_keys(parsed_json(data))
            return {
                old: check_string(new, f"the new name of {old}") for old, new in document.items()
            }
        lines = data.decode("utf-8", "surrogateescape").splitlines()
        between = next((mark for mark in ",;\t" if any(mark in line for line in lines)), ",")
        rows = [*csv.reader(lines, delimiter=between)]
        if wrong := [row for row in rows if row and len(row) != 2]:
            raise FormatError(
                "expected a JSON object, or a CSV with two columns, the old and the new names; "
                f"found {between.join(wrong[0])[:80]!r}"
            )
        return dict(row for row in rows if row)


def joint_names_in_scheme(motion: Motion, naming: str) -> Mapping[str, str]:
    """Return new names for the recognised joints, keyed by old name.

    `naming` is the scheme of the new names, 'cmu' or 'smpl'.

    Joints are recognised by the names of either scheme. Arms and legs are also recognised by any
    other known name.
    """
    names = {"cmu": CMU_NAMES, "smpl": SMPL_NAMES}[naming]
    found = dict[str, str]()
    body = find_body(motion)
    for joint, bone in zip(body.skeleton.names, body.joint_roles, strict=True):
        word = bone.replace(" ", "").replace("Toe", "ToeBase")
        for known in (CMU_NAMES, SMPL_NAMES):
            word = CMU_NAMES[known.index(joint)] if joint in known else word
        if word in CMU_NAMES and (new := names[CMU_NAMES.index(word)]) not in found.values():
            found[joint] = new
    return found
