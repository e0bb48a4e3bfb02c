"""Measure detection in clean clips written with coarse numbers or few keys.

    python -m benchmarks.notation FOLDER… [--clips N] [--seeds N]

Every BVH in the folders is corrected until nothing is found (unless --as-it-is is given), and then
written as other programs do: with angles in whole degrees or in tenths, with frames held at 120
frames per second, or with linear keys every 5, 10 or 15 frames. The table shows

- the automatic corrections per minute, compared with those in the clip itself (for held frames and
  keys also with the kept frames at their own rate), and
- how many errors of 15-150° are repaired. These errors are injected before writing and, for held
  frames and keys, also after it, frame by frame.

An error counts as repaired if four fifths of its frames, or of its keys, are corrected by at least
four fifths. The exit status is 1 if any notation has over 0.2 corrections per minute more than the
clip itself.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import (
    automatic_corrections,
    offsets_by_chain,
    refine,
)
from twistcore.detection import Interval, Kind
from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.formats.bvh import parse_bvh, read_bvh
from twistcore.formats.bvh.clip import BvhClip
from twistcore.formats.bvh.reader import bvh_timing_number_spans
from twistcore.formats.clip import create_file_patch_for_motion
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import Array, wrap
from twistcore.synthesis import (
    InjectedError,
    clip_random_generator,
    draw_errors,
    draw_targets,
    inject,
    parse_protocol,
)

HELD_FPS = 120.0
MOST = 0.2  # largest allowed number of additional automatic corrections per minute
ROUNDS = 3  # maximum number of times that a clip is corrected until nothing is found
REPAIRED = 0.8  # minimum share of the frames, and of the error, that must be corrected


@dataclass(frozen=True)
class Notation:
    """A way to write a clip.

    Attributes
    ----------
    name
        Name of the notation.
    step
        The step to which angles are rounded, in degrees, or 0.
    held
        True to repeat frames.
    keys
        The number of frames between linear keys, or 0.
    """

    name: str
    step: float = 0.0
    held: bool = False
    keys: int = 0

    def repeats(self, fps: float) -> tuple[int, int]:
        """Return the interval between kept frames, and how often each is repeated.

        For held frames, about 30 frames per second are kept. `fps` is the clip's frame rate.
        """
        if self.keys:
            return self.keys, self.keys
        kept = max(1, round(fps / 30.0)) if self.held else 1
        return kept, max(1, round(HELD_FPS * kept / fps)) if self.held else 1

    def written(self, clip: BvhClip, often: int) -> BvhClip:
        """Return the kept frames of a clip in this notation, each frame repeated `often` times."""
        values, fps = clip.values.copy(), 1.0 / clip.frame_time
        angles = [k for c in clip.channels for k in c.rotation]
        if self.step:
            values[:, angles] = np.round(values[:, angles] / self.step) * self.step
        if self.keys:
            values[:, angles] = np.degrees(np.unwrap(np.radians(values[:, angles]), axis=0))
            at = np.arange((len(values) - 1) * often + 1) / often
            keys = np.arange(len(values))
            values = np.stack([np.interp(at, keys, v) for v in values.T], axis=1)
        if self.held:
            values = values.repeat(often, axis=0)
        fps *= often
        return with_values(clip, values, 1.0 / fps)


PLAIN = Notation("as it is")
NOTATIONS = (
    Notation("whole degrees", step=1.0),
    Notation("tenths", step=0.1),
    Notation("held", held=True),
    *(Notation(f"keys every {n}", keys=n) for n in (5, 10, 15)),
)


def with_values(clip: BvhClip, values: Array, frame_time: float) -> BvhClip:
    """Return the clip with different rows of numbers, as if read from a file."""
    (f0, f1), (t0, _) = bvh_timing_number_spans(clip.data)
    rows = "\n".join(" ".join(f"{v:.6f}" for v in row) for row in values.tolist())
    data = clip.data
    head = data[:f0] + str(len(values)).encode() + data[f1:t0] + f"{frame_time:.9g}".encode()
    return parse_bvh(head + b"\n" + rows.encode() + b"\n", clip.path)


def kept(clip: BvhClip, notation: Notation) -> BvhClip:
    """Return the clip with which a notation is compared: every frame that the notation keeps."""
    every, _ = notation.repeats(1.0 / clip.frame_time)
    return with_values(clip, clip.values[::every], clip.frame_time * every) if every > 1 else clip


def sound(clip: BvhClip) -> BvhClip:
    """Return the clip after its automatic corrections, for use as a clip without errors."""
    for _ in range(ROUNDS):
        found = analyse(clip).detect()
        if not (applied := automatic_corrections(found)):
            break
        without = refine(clip.motion, found.chains_and_limbs, applied)
        clip = parse_bvh(create_file_patch_for_motion(clip, without).data, clip.path)
    return clip


def corrections(clip: BvhClip) -> tuple[Interval, ...]:
    """Return the automatic corrections of a clip."""
    return automatic_corrections(analyse(clip).detect())


def drawn(clip: BvhClip, seed: int, words: str) -> tuple[list, tuple[InjectedError, ...]]:
    """Return the chains of a clip, and random errors of 15-150° in two of them.

    `seed` and `words` seed the errors together with the clip's name.
    """
    protocol = replace(parse_protocol("P0"), delta=(15.0, 150.0))
    rng = clip_random_generator(seed, clip.name + words)
    chains = find_chains(clip.motion)
    targets = draw_targets(chains, rng, protocol)
    first = max(1, count_leading_rest_frames(clip.motion))
    return chains, draw_errors(clip.motion, targets, rng, protocol, first=first)


def with_errors(clip: BvhClip, chains: Sequence, errors: Sequence[InjectedError]) -> BvhClip:
    """Return the clip with errors, written to a file and read back."""
    return parse_bvh(
        create_file_patch_for_motion(clip, inject(clip.motion, chains, errors)).data, clip.path
    )


def by_chain(found: Sequence[Interval], frames: int) -> dict[str, Array]:
    """Return the offsets of the counter-twists in radians, (frames,), keyed by chain name."""
    return offsets_by_chain((i for i in found if i.kind == Kind.COUNTER_TWIST), frames)


def repaired(errors: Sequence[InjectedError], offsets: dict[str, Array]) -> int:
    """Return the number of repaired errors. `offsets` is the result of :func:`by_chain`."""
    count = 0
    for e in errors:
        taken = offsets[e.chain][e.start : e.stop] if e.chain in offsets else 0.0
        left, size = np.abs(wrap(e.offset - taken)), np.abs(e.offset)
        count += bool((left <= (1.0 - REPAIRED) * size).mean() >= REPAIRED)
    return count


class Row:
    """The counts for one notation.

    Attributes
    ----------
    seconds
        Duration of the clips.
    found, of_clip, of_kept
        Numbers of automatic corrections in the notation, in the clips, and in the kept frames.
    kinds
        Number of corrections, keyed by kind.
    errors, repaired
        Numbers of injected and of repaired errors, keyed by 'before' or 'after' writing.
    """

    def __init__(self) -> None:
        self.seconds = 0.0
        self.found = self.of_clip = self.of_kept = 0
        self.kinds: Counter[str] = Counter()
        self.errors: Counter[str] = Counter()
        self.repaired: Counter[str] = Counter()

    def recall(self, when: str) -> str:
        """Return the share of repaired errors, such as '93.1 (54/58)', or '' if there are none."""
        if not self.errors[when]:
            return ""
        n, of = self.repaired[when], self.errors[when]
        return f"{100.0 * n / of:.1f} ({n}/{of})"

    def to_json(self) -> dict:
        """Return the row as a dictionary, keyed by field name."""
        return {k: dict(v) if isinstance(v, Counter) else v for k, v in vars(self).items()}


def measure(clip: BvhClip, notation: Notation, row: Row, seeds: int, show: bool) -> None:
    """Measure one clip and add the results to the row. `show` is True to print each correction."""
    base = kept(clip, notation)
    _, often = notation.repeats(1.0 / clip.frame_time)
    whole = notation.written(base, often)
    found = corrections(whole)
    row.found += len(found)
    row.of_kept += len(corrections(base))
    row.seconds += clip.frames * clip.frame_time
    row.kinds.update(
        (i.evidence or {}).get("follows", i.kind.value if not i.evidence else "its edges")
        if i.kind.value == "counter-twist"
        else i.kind.value
        for i in found
    )
    if show:
        for i in found:
            print(
                f"  {notation.name}: {clip.name} {i.chain} {i.start}-{i.stop} "
                f"{np.degrees(i.delta):+.1f}° {i.confidence:.2f} {i.kind}"
            )
    for seed in range(seeds):
        chains, errors = drawn(base, seed, "")
        erring = notation.written(with_errors(base, chains, errors), often)
        offsets = by_chain(corrections(erring), erring.frames)
        kept_offsets = {name: v[::often] for name, v in offsets.items()}
        row.errors["before"] += len(errors)
        row.repaired["before"] += repaired(errors, kept_offsets)
        if notation.held or notation.keys:
            chains, errors = drawn(whole, seed, "after")
            erring = with_errors(whole, chains, errors)
            row.errors["after"] += len(errors)
            offsets = by_chain(corrections(erring), erring.frames)
            row.repaired["after"] += repaired(errors, offsets)


def main() -> int:
    """Measure every notation and print a table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n", 1)[0])
    parser.add_argument("folder", type=Path, nargs="+")
    parser.add_argument("--clips", type=int, default=None, help="the first N of each folder")
    parser.add_argument("--seeds", type=int, default=1, help="seeds of injected errors per clip")
    parser.add_argument("--only", default="", help="only notations with this in their name")
    parser.add_argument("--as-it-is", action="store_true", help="do not correct the clips first")
    parser.add_argument("--show", action="store_true", help="print every correction")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    notations = [n for n in (PLAIN, *NOTATIONS) if options.only in n.name]
    rows = {n.name: Row() for n in notations}
    for folder in options.folder:
        for path in list(clip_paths_in_folder(folder, suffixes=BVH))[: options.clips]:
            clip = read_bvh(path) if options.as_it_is else sound(read_bvh(path))
            own = len(corrections(clip))
            for n in notations:
                rows[n.name].of_clip += own
                measure(clip, n, rows[n.name], options.seeds, options.show)
    print(
        f"{'':>14} {'a minute':>9} {'clip':>7} {'more':>6} {'kept':>7}  "
        f"{'repaired, before':>18} after"
    )
    worst = 0.0
    for name, row in rows.items():
        found, clip, of_kept = (
            60.0 * n / row.seconds for n in (row.found, row.of_clip, row.of_kept)
        )
        worst = max(worst, found - clip)
        print(
            f"{name:>14} {found:>9.2f} {clip:>7.2f} {found - clip:>6.2f} {of_kept:>7.2f}  "
            f"{row.recall('before'):>18} {row.recall('after')}  {dict(row.kinds)}"
        )
    if options.json:
        options.json.write_text(json.dumps({k: r.to_json() for k, r in rows.items()}, indent=1))
    return int(worst > MOST)


if __name__ == "__main__":
    sys.exit(main())
