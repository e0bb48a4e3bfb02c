"""Measure corrections on common rigs: python -m benchmarks.rigs FOLDER [--clips N] [--json FILE].

FOLDER contains CMU clips with the joint names of MotionBuilder. Each clip is converted to every rig
in `benchmarks._rig_families`. For each rig, 58 errors of 15-150° that last 1-30 frames are spread
over the clips. In each error, a joint P rotates about its bone, and its children rotate back. Every
rig gets the same errors at the same joints and frames. Then the automatic corrections are applied.

A frame counts as repaired if at most a fifth of its error is left, in P and in each of its
children. The column "made wrong" counts joints that are changed by more than 1° in frames without
an error, and `sound` does so in clips without errors. The column "chains" shows how many of the ten
pairs of P and its child are examined. A rig in pieces has one line for each share of a bone's roll
in its first piece: none, half, all. The other pieces share the rest and, as in pronation of the
forearm, some roll of the next joint. The results "between pieces" are for errors of a piece
relative to the next piece of its bone, in a separate run.

Clips that are corrected even without injected errors are left out. --missed lists every error that
is not repaired, with the reason.

Five rigs come from public sources, and nothing is tuned on them:

| rig | names and hierarchy from |
|---|---|
| Fallout 4 | BadDogSkyrim/PyNifly, PyNifly/niflytools.py: the bones of FO4 with their parents |
| Final Fantasy XIV | Aether-Tools/CustomizePlus, CustomizePlus/Core/Data/BoneData.cs |
| Source engine | GMod PM Proportion Tool: $definebone lines of Half-Life 2's female skeleton |
| Second Life Bento | secondlife/viewer, indra/newview/character/avatar_skeleton.xml |
| 3ds Max CAT | ConnorTidd/SurviveVR, EnemyFiles/testMovement.clp, a clip that CAT exported |

The share of the roll of a piece or helper, and its place along a bone, are our choice in every rig.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from benchmarks._rig_families import RIGS
from benchmarks._rigs import Rig, bone_pairs, piece_pairs, rigged
from twistcore.analysis.clip_analysis import REPAIRED, Detection, analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections, refine
from twistcore.detection import Interval
from twistcore.detection.cuts import count_leading_rest_frames
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip_files import BVH, clip_paths_in_folder
from twistcore.skeleton.chain import make_chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, geodesic_angle
from twistcore.synthesis import SUCCESS, InjectedError, clip_random_generator, inject

ERRORS = 58
SMALLEST, LARGEST = 15.0, 150.0  # degrees
LONGEST = 30  # frames
APART = 10  # frames between errors of a limb
EDGE = 2  # frames of the clip before the first error and after the last one
CLIP = 600  # frames; a longer clip is cut
CHANGED = float(np.radians(1.0))
EXACT = float(np.radians(0.5))
SHARES = (0.0, 0.5, 1.0)
_TRIES = 500
_JOINTS = ("Hips", "LeftUpLeg", "RightArm", "LeftHand")  # joints by which CMU clips are recognised


class Pair(NamedTuple):
    """The joints of a possible error.

    Attributes
    ----------
    parent, child
        Indices of the joint that rotates and of one of its children.
    limb
        The side and True for a leg, which identify the limb of both.
    """

    parent: int
    child: int
    limb: tuple[int, bool]


class Place(NamedTuple):
    """The place of an injected error.

    Attributes
    ----------
    pair
        Index of the pair of joints.
    start, stop
        The frames [start, stop).
    offset
        The angle in radians.
    """

    pair: int
    start: int
    stop: int
    offset: float


@dataclass(frozen=True)
class Missed:
    """An error that was not repaired, with the reason `why`."""

    rig: str
    share: float
    clip: str
    joints: str
    start: int
    stop: int
    degrees: float
    why: str


@dataclass(frozen=True)
class Count:
    """The results for the errors on a rig.

    Attributes
    ----------
    errors, repaired
        Numbers of errors and of repaired errors.
    frames, repaired_frames, exact_frames
        Numbers of error frames, of repaired ones, and of those repaired to within 0.5°.
    made_wrong
        Number of joints changed without an error, summed over frames.
    sound
        The same number in clips without errors.
    pairs, chains
        Number of pairs of joints, and number of pairs that are examined.
    missed
        The errors that were not repaired.
    """

    errors: int = 0
    repaired: int = 0
    frames: int = 0
    repaired_frames: int = 0
    exact_frames: int = 0
    made_wrong: int = 0
    sound: int = 0
    pairs: int = 0
    chains: int = 0
    missed: tuple[Missed, ...] = ()

    def __add__(self, other: Count) -> Count:
        return Count(**{name: value + getattr(other, name) for name, value in vars(self).items()})

    @property
    def percent(self) -> float:
        """Return the percentage of error frames that are repaired."""
        return 100.0 * self.repaired_frames / self.frames if self.frames else 100.0


def drawn(
    limbs: Sequence[tuple[int, bool]], frames: int, number: int, rng: np.random.Generator
) -> list[Place]:
    """Return random errors that are at least APART frames apart in each limb.

    Parameters
    ----------
    limbs
        The limb of each pair of joints.
    frames
        Number of frames of the clip.
    number
        Number of errors.
    rng
        The source of random numbers.
    """
    places: list[Place] = []
    for _ in range(number if limbs else 0):
        for _ in range(_TRIES):
            pair, length = int(rng.random() * len(limbs)), int(rng.integers(1, LONGEST + 1))
            degrees = rng.uniform(SMALLEST, LARGEST) * rng.choice([-1.0, 1.0])
            room = frames - 2 * EDGE - length
            start = EDGE + int(rng.random() * room)
            near = (p for p in places if limbs[p.pair] == limbs[pair])
            if room > 0 and all(
                start >= p.stop + APART or start + length + APART <= p.start for p in near
            ):
                places.append(Place(pair, start, start + length, float(np.radians(degrees))))
                break
    return places


def with_errors(motion: Motion, pairs: Sequence[Pair], places: Sequence[Place]) -> Motion:
    """Inject errors: rotate the parent of each pair about its bone, and its children back."""
    chains, errors = {}, []
    for place in places:
        pair = pairs[place.pair]
        chain = make_chain(motion, pair.parent, pair.child)
        assert chain is not None, "a bone without length"
        chains[chain.name] = chain
        offset = np.full(place.stop - place.start, place.offset)
        errors.append(InjectedError(chain.name, place.start, place.stop, offset))
    return inject(motion, tuple(chains.values()), errors)


def corrected(motion: Motion) -> tuple[Motion, Detection]:
    """Return the motion after its automatic corrections, and the detection."""
    found = analyse(motion).detect(kinds=REPAIRED)
    return refine(motion, found.chains_and_limbs, automatic_corrections(found)), found


def counted(
    motion: Motion, pairs: Sequence[Pair], places: Sequence[Place], rig: Rig, clip: str
) -> Count:
    """Inject errors into a motion on a rig, correct them automatically, and count the results."""
    refined, found = corrected(with_errors(motion, pairs, places))
    left = geodesic_angle(motion.rotations, refined.rotations)
    turned = np.zeros(left.shape, dtype=bool)
    total = Count()
    for place in places:
        pair, at = pairs[place.pair], slice(place.start, place.stop)
        joints = [pair.parent, *motion.skeleton.children[pair.parent]]
        turned[at, joints] = True
        error: Array = left[at, joints].max(axis=1)
        good = error <= SUCCESS * abs(place.offset)
        missed = ()
        if not good.all():
            why = reason(found, pair, place)
            names = " → ".join(motion.skeleton.names[j] for j in pair[:2])
            degrees = float(np.degrees(place.offset))
            missed = (
                Missed(rig.name, rig.share, clip, names, place.start, place.stop, degrees, why),
            )
        total += Count(
            errors=1,
            repaired=int(good.all()),
            frames=len(good),
            repaired_frames=int(good.sum()),
            exact_frames=int((error <= EXACT).sum()),
            missed=missed,
        )
    looked_at = {(chain.parent, chain.child) for chain in found.chains}
    return total + Count(
        made_wrong=int((left[~turned] > CHANGED).sum()),
        pairs=len(pairs),
        chains=sum(pair[:2] in looked_at for pair in pairs),
    )


def reason(found: Detection, pair: Pair, place: Place) -> str:
    """Return the reason why an error was not repaired."""
    chains = {c.name: c for c in found.chains_and_limbs}
    own = [c.name for c in found.chains if (c.parent, c.child) == pair[:2]]
    near = [i for i in found if i.start < place.stop + 2 and place.start - 2 < i.stop]
    applied = set(map(id, automatic_corrections(near)))

    def listed(intervals: list[Interval]) -> str:
        return ", ".join(
            f"{i.chain} {i.start}-{i.stop} {np.degrees(i.shown):+.0f}°"
            + ("" if id(i) in applied else _why_left(i))
            for i in intervals
        )

    on_pair = [i for i in near if i.chain in own]
    joints = set(pair[:2])
    others = [i for i in near if joints & {chains[i.chain].parent, chains[i.chain].child}]
    if not own:
        return "no chain of the pair" + (f"; taken for {listed(others)}" if others else "")
    if on_pair:
        return f"found as {listed(on_pair)}"
    return f"not found; taken for {listed(others)}" if others else "not found"


def _why_left(interval: Interval) -> str:
    """Return why an interval was not corrected automatically."""
    why = "open" if interval.open else f"confidence {interval.confidence or 0.0:.2f}"
    return f" not applied ({why})"


def sound_changes(motion: Motion) -> int:
    """Return the number of joints that a correction changes by more than 1°, summed over frames."""
    refined, _ = corrected(motion)
    return int((geodesic_angle(motion.rotations, refined.rotations) > CHANGED).sum())


def run(clips: dict[str, Motion], rig: Rig, seed: int) -> tuple[Count, Count]:
    """Return the results for errors at limb joints, and for errors between pieces of a bone.

    `clips` has the CMU motions, keyed by name.
    """
    at_joints, between = Count(), Count()
    for k, (name, motion) in enumerate(clips.items()):
        made = rigged(motion, rig)
        number = (ERRORS * (k + 1)) // len(clips) - (ERRORS * k) // len(clips)
        joints = [
            Pair(parent, child, (side, "Leg" in role))
            for (side, role), (parent, child) in bone_pairs(made, rig).items()
        ]
        places = drawn(
            [p.limb for p in joints], made.frames, number, clip_random_generator(seed, name)
        )
        sound = Count(sound=sound_changes(made))
        at_joints += counted(made, joints, places, rig, name) + sound
        if not rig.in_pieces:
            continue
        pieces = [Pair(*pair, limb) for pair, limb in piece_pairs(made, rig)]
        places = drawn(
            [p.limb for p in pieces], made.frames, number, clip_random_generator(seed, name, 1)
        )
        between += counted(made, pieces, places, rig, name)
    return at_joints, between


def sound_clips(folder: Path, number: int) -> dict[str, Motion]:
    """Return evenly spaced CMU clips that need no automatic correction, keyed by name."""
    found: dict[str, Motion] = {}
    for path in clip_paths_in_folder(folder, suffixes=BVH):
        motion = read_bvh(path).motion
        if not set(_JOINTS) <= set(motion.skeleton.names):
            continue
        first = count_leading_rest_frames(motion)
        motion = motion.sliced(first, min(motion.frames, first + CLIP))
        if not sound_changes(motion):
            found[path.stem] = motion
    names = list(found)
    number = min(number, len(names))
    chosen = [names[(k * len(names)) // number] for k in range(number)]
    return {name: found[name] for name in chosen}


def variants(rig: Rig) -> list[Rig]:
    """Return a variant of a rig for each share of the roll if it has pieces, or only the rig."""
    return [replace(rig, share=share) for share in SHARES] if rig.in_pieces else [rig]


def line(rig: Rig, at_joints: Count, between: Count) -> str:
    """Return a row of the table."""
    share = f"{100 * rig.share:.0f} %" if rig.in_pieces else ""
    cells = [
        rig.name,
        share,
        f"{at_joints.chains / max(at_joints.pairs, 1) * 10:.0f}",
        f"{at_joints.repaired} of {at_joints.errors}",
        f"{at_joints.percent:.1f}",
        f"{100 * at_joints.exact_frames / max(at_joints.frames, 1):.1f}",
        f"{at_joints.made_wrong}",
        f"{at_joints.sound}",
        f"{between.percent:.1f}" if between.errors else "",
        f"{between.made_wrong}" if between.errors else "",
    ]
    return "| " + " | ".join(cells) + " |"


HEAD = (
    "| rig | first piece's roll | chains | errors repaired | frames % | within 0.5° % | made wrong "
    "| sound | between pieces % | made wrong |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|"
)


def main() -> None:
    """Measure all rigs and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--clips", type=int, default=6)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rig", default="", help="only rigs with this in their name")
    parser.add_argument("--missed", action="store_true", help="list errors that are not repaired")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    clips = sound_clips(given.folder, given.clips)
    print(f"{len(clips)} clips: {', '.join(clips)}; seed {given.seed}")
    rows, group = [], ""
    for rig in RIGS:
        if given.rig.lower() not in rig.name.lower():
            continue
        if rig.group != group:
            group = rig.group
            print(f"\n{group[0].upper()}{group[1:]}:\n\n{HEAD}")
        for variant in variants(rig):
            at_joints, between = run(clips, variant, given.seed)
            print(line(variant, at_joints, between), flush=True)
            own = {"rig": rig.name, "group": group, "share": variant.share, "source": rig.source}
            rows.append(own | {"joints": asdict(at_joints), "between": asdict(between)})
            if given.missed:
                for m in (*at_joints.missed, *between.missed):
                    print(f"    {m.clip} {m.joints} {m.start}-{m.stop} {m.degrees:+.0f}°: {m.why}")
    if given.json:
        document = {"clips": list(clips), "seed": given.seed, "rows": rows}
        given.json.write_text(json.dumps(document, ensure_ascii=False, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
