"""Run all cross-checks with other programs: python -m benchmarks.crosschecks FOLDER…

    python -m benchmarks.crosschecks FOLDER… [--blender PYTHON] [--uncorrected] [--list FILE]

For every BVH file in or below the folders (test files of other libraries are useful), these
conditions are checked:

- The file is read, or refused with a message. Any other result is a fault.
- A file written without corrections has the same bytes.
- Joints have the same positions in pybvh, as read, rewritten and corrected
  (:mod:`benchmarks.bvh_crosscheck`), and, if PYTHON can import bpy, in Blender, rewritten and
  corrected (:mod:`benchmarks.blender_check`).

--uncorrected skips the correction, which takes the most time. --list writes a line of JSON per
file. The exit status is 1 if a file causes a fault or is changed by writing, or if the position of
a joint differs. Files that pybvh or Blender refuses are counted but not judged. AMC files have a
separate command, :mod:`benchmarks.amc_crosscheck`, and the pages of a report have the test
`python3 dev.py test tests/gui/test_report_in_browser.py`.
"""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks import blender_check, bvh_crosscheck
from benchmarks.odd_files import comes_back
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip_files import BVH, clip_paths_in_folder


@dataclass(frozen=True)
class Peer:
    """The result of another program for a file.

    Attributes
    ----------
    name
        Name of the program.
    distances
        Largest distances of joints as shares of the height.
    most
        Largest allowed distances.
    refused
        The program's message if it refused the file, or ''.
    """

    name: str
    distances: tuple[float, ...] = ()
    most: tuple[float, ...] = ()
    refused: str = ""

    @property
    def outcome(self) -> str:
        """Return the outcome as a single word."""
        if self.refused:
            return "refuses"
        fits = all(d <= most for d, most in zip(self.distances, self.most, strict=True))
        return "agrees" if fits else "DIFFERS"


@dataclass(frozen=True)
class Checked:
    """The result of checking one file.

    Attributes
    ----------
    path
        The file.
    outcome
        'read', 'refused' or 'FAULT'.
    said
        The reader's message, or the size of the clip.
    kept
        True if writing without corrections keeps all bytes.
    peers
        The results of other programs.
    """

    path: str
    outcome: str
    said: str = ""
    kept: bool = True
    peers: tuple[Peer, ...] = ()

    @property
    def is_wrong(self) -> bool:
        """Whether the check found a fault."""
        differs = any(peer.outcome == "DIFFERS" for peer in self.peers)
        return self.outcome == "FAULT" or not self.kept or differs


def checked(path: Path, blender: str | None, *, correct: bool) -> Checked:
    """Check a file with our reader and with other programs.

    `blender` is an interpreter that can import bpy, or None. `correct` is True to compare corrected
    files as well.
    """
    try:
        clip = read_bvh(path)
        kept = comes_back(clip)
    except TwistError as error:
        return Checked(str(path), "refused", str(error).replace(str(path), path.name))
    except Exception as error:
        return Checked(str(path), "FAULT", f"{type(error).__name__}: {error}")
    peers = [asked("pybvh", lambda: _by_pybvh(path, correct), bvh_crosscheck.MOST)]
    if blender:
        peers.append(
            asked("Blender", lambda: _by_blender(path, blender), (blender_check.MOST,) * 2)
        )
    said = f"{clip.motion.frames} frames, {len(clip.skeleton)} joints"
    return Checked(str(path), "read", said, kept, tuple(peers))


def asked(name: str, ask: Callable[[], tuple[float, ...]], most: tuple[float, ...]) -> Peer:
    """Return the result of another program. An exception in it counts as a refusal."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = ask()
    except TwistError as error:
        return Peer(name, refused=f"not corrected: {error}")
    except Exception as error:
        said = str(error).splitlines() or [""]
        return Peer(name, refused=f"{type(error).__name__}: {said[-1][:120]}")
    return Peer(name, found, most[: len(found)])


def _by_pybvh(path: Path, correct: bool) -> tuple[float, ...]:
    found = bvh_crosscheck.differences(path)
    return (*found, bvh_crosscheck.corrected(path)[0]) if correct else found


def _by_blender(path: Path, blender: str) -> tuple[float, ...]:
    return tuple(found["worst"] for found in blender_check.compared(path, blender))


def line_of(one: Checked) -> str:
    """Return the output line for a file."""
    words = [one.path, one.outcome, one.said, "" if one.kept else "COMES BACK CHANGED"]
    for peer in one.peers:
        figures = " ".join(f"{d:.1e}" for d in peer.distances)
        words.append(f"{peer.name} {peer.outcome} {figures or peer.refused}")
    return "  ".join(filter(None, words))


def summary(files: list[Checked]) -> list[str]:
    """Return lines of text with the counts over all files."""
    ours = Counter(one.outcome for one in files)
    lines = [
        f"{len(files)} files: {ours['read']} read, {ours['refused']} refused with a sentence, "
        f"{ours['FAULT']} ended in a fault, {sum(not one.kept for one in files)} came back changed"
    ]
    for name in sorted({peer.name for one in files for peer in one.peers}):
        answers = [peer for one in files for peer in one.peers if peer.name == name]
        count = Counter(peer.outcome for peer in answers)
        worst = max((max(p.distances) for p in answers if p.distances), default=0.0)
        lines.append(
            f"{name}: {count['agrees']} agree, {count['DIFFERS']} differ, {count['refuses']} "
            f"refused by it; worst {worst:.1e} of the height"
        )
    return lines


def main() -> int:
    """Check all files, and print one line for each and the counts."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--blender", metavar="PYTHON", help="an interpreter that can import bpy")
    parser.add_argument("--uncorrected", action="store_true")
    parser.add_argument("--list", type=Path, metavar="FILE")
    arguments = parser.parse_args()
    files = []
    for folder in arguments.folders:
        for path in sorted(clip_paths_in_folder(folder, below=True, suffixes=BVH)):
            files.append(checked(path, arguments.blender, correct=not arguments.uncorrected))
            print(line_of(files[-1]), flush=True)
    if arguments.list:
        lines = [json.dumps(asdict(one)) + "\n" for one in files]
        arguments.list.write_text("".join(lines), "utf-8")
    print("\n".join(summary(files)))
    return int(any(one.is_wrong for one in files))


if __name__ == "__main__":
    sys.exit(main())
