"""List how each file in a folder is read: python -m benchmarks.odd_files FOLDER [--write PAGE].

The table has one row per file: the reader's error or warnings, whether the file is reproduced byte
for byte without corrections, the number of chains, and the reason for this result. With --write,
the rows replace those between the marks in PAGE, such as benchmarks/odd_files.md. The exit status
is 1 if a readable file is not reproduced byte for byte.
"""

from __future__ import annotations

import argparse
import re
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from twistcore.errors import BvhError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import Clip, write_clip
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.skeleton.chain import find_chains

BEGIN, END = "<!-- odd files: begin -->", "<!-- odd files: end -->"

# The reason for each message of the reader. The first match is used.
OUTCOMES = {
    "numbers in this row": "every later number would move into another channel",
    "expected MOTION": "there is no motion",
    "expected HIERARCHY": "there is no skeleton",
    "expected ROOT, JOINT": "the braces do not say whose joint it is",
    "'}'": "the braces do not say whose joint it is",
    "expected a": "there is no pose without this number",
    "more than once": "the hierarchy is clear without the names",
    "whole rows were read": "the rows exist, the header only claims",
    "incomplete": "it has no whole pose",
    "CHANNELS twice": "the rows fit only so",
    "second OFFSET": "the rows fit only so",
    "not usable": "poses do not depend on the rate, and `--fps` sets it",
}
# The reason for a file without a message, by a part of the file's name.
ODDITIES = {
    "rotation_before_position": "each joint's channels have their own order",
    "orders": "each joint's channels have their own order",
    "ZYX_and_ZXY": "each joint's channels have their own order",
    "full_precision": "a number has as many digits as it likes; the rate is kept as written",
    "mixamorig": "a namespace is part of the name; chains are found behind it",
    "channels_0": "a joint without channels stays where OFFSET puts it; names end at the line",
    "without_EndSite": "no number depends on an End Site; `1e-05` is a number, a tab a space",
    "6ch_leaves": "positions next to zero are shifts from OFFSET, which gives the bones",
    "6ch": "position channels replace OFFSET, on any joint",
    "frame_time_1": "one second a frame is slow, not absurd",
    "single_frame": "one pose is a motion; a quarter of a second a frame is slow, not absurd",
    "mixed_EOL": "every line may end as it likes, and does so again when written",
    "long_frametime": "names are free; the rate is kept as written",
    "angles_beyond": "a correction stays on its neighbours' turn",
    "tabs": "a tab is a space",
}
PLAIN = "nothing in the file is unusual"


@dataclass(frozen=True)
class Row:
    """The result for one file.

    Attributes
    ----------
    name
        Name of the file.
    done
        How the file was read.
    why
        The reason.
    kept
        True if the file's bytes were reproduced.
    """

    name: str
    done: str
    why: str
    kept: bool


def row(path: Path) -> Row:
    """Read a file and return its row of the table."""
    try:
        clip = read_bvh(path)
    except BvhError as error:
        place = "" if error.line is None else f"line {error.line}: "
        return Row(
            path.stem, f"**refused**, {place}{error.expected}", _why(error.expected, path), True
        )
    kept = comes_back(clip)
    frames, joints = clip.motion.frames, len(clip.skeleton)
    counts = f"{_many(frames, 'frame')}, {_many(joints, 'joint')}"
    chains = _many(len(find_chains(clip.motion)), "chain")
    told = " ".join(f"*{warning}*" for warning in clip.warnings)
    done = f"read ({counts}, {chains})" + (f"; {told}" if told else "")
    return Row(
        path.stem, done if kept else f"{done} **comes back changed**", _why(told, path), kept
    )


def _many(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"


def _why(outcome: str, path: Path) -> str:
    told = [why for part, why in OUTCOMES.items() if part in outcome]
    named = [why for part, why in ODDITIES.items() if part in path.stem]
    return (told or named or [PLAIN])[0]


def comes_back(clip: Clip) -> bool:
    """Return True if writing the clip without corrections reproduces its bytes."""
    with tempfile.TemporaryDirectory() as folder:
        again = Path(folder) / "again.bvh"
        write_clip(clip, clip.motion.with_rotations(clip.motion.rotations.copy()), again)
        return again.read_bytes() == clip.data


def table(rows: list[Row]) -> str:
    """Return the table in Markdown."""
    lines = ["| File | What we do | Why |", "|---|---|---|"]
    lines += [f"| `{r.name}` | {_cell(r.done)} | {r.why} |" for r in rows]
    return "\n".join(lines)


def _cell(text: str) -> str:
    return re.sub(r"([|<>])", r"\\\1", text)


def written_into(page: str, rows: list[Row]) -> str:
    """Return the page with the table between its marks. Raises ValueError if there are no marks."""
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"expected the marks {BEGIN} and {END}")
    return f"{before}{BEGIN}\n{table(rows)}\n{END}{after}"


def main() -> int:
    """Print the table, or write it into the page. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", type=Path, metavar="PAGE")
    arguments = parser.parse_args()
    rows = [row(path) for path in clip_paths_in_folder(arguments.folder, below=True, suffixes=BVH)]
    if arguments.write:
        page = arguments.write.read_text("utf-8")
        arguments.write.write_text(written_into(page, rows), "utf-8")
    else:
        print(table(rows))
    kept = sum(r.kept and "**refused**" not in r.done for r in rows)
    refused = sum("**refused**" in r.done for r in rows)
    print(f"{len(rows)} files: {kept} come back byte for byte, {refused} refused", file=sys.stderr)
    return int(kept + refused < len(rows))


if __name__ == "__main__":
    sys.exit(main())
