"""Judge real flips of whole limbs before and after correction.

    python -m benchmarks.real_flips FOLDER

    python3 dev.py bench real_flips FOLDER [--json FILE] [--clips GLOB]

The joints of a limb are called P, C and E: hip, knee and ankle, or shoulder, elbow and wrist. Every
clip is corrected as by `twistcore refine`, written, read back, and judged only by the world
positions and orientations of its joints. The following are counted:

- impossible swivel: between two frames, C rotates about the line from P to E faster than any body
  can, while E hardly moves relative to P
- backward knee: a frame in which C of a leg is more than 110° away from its usual side in the clip
  before correction, in the coordinates of P's parent
- impossible turn: between two frames, P or a joint below it rotates too fast about its own bone; a
  turn is new if it was absent before correction
- mirrored transition: P and C rotate against each other (:mod:`benchmarks.mirrored_turns`)
- rotation of P in frames with a bent and with a straight limb
- displacement of E, and of C in clips without an impossible swivel, as a share of the skeleton's
  height, if it exceeds the rounding of the written numbers

Jumps in frames 0 and 1 are not examined, because a T-pose often comes first. A clip that cannot be
read or corrected is listed. The exit status is 1 if the correction did harm: E moved, a clip
without a flip changed, there is a new impossible turn, or a bent limb changed in a clip without a
mirrored transition.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from benchmarks._limb_poses import (
    Array,
    Jump,
    Limb,
    Pose,
    backward,
    find,
    moved,
    own_side,
    pose,
    spins,
    swivels,
    unit,
)
from benchmarks._refined import refine_file
from benchmarks.mirrored_turns import Straightness, bends, mirrored, straightness
from twistcore.errors import TwistError
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import Clip
from twistcore.skeleton.motion import Motion


@dataclass(frozen=True)
class Verdict:
    """The verdict on one clip, before and after correction.

    Attributes
    ----------
    clip
        Name of the clip.
    frames, limbs
        Numbers of frames and of limbs.
    swivels_before, swivels_after
        Impossible swivels.
    backward_before, backward_after
        Frames with a backward knee, keyed by limb.
    turns_old, turns_left, turns_new
        Impossible turns: before the correction, left by it, and added by it.
    e_moved, c_moved
        The largest displacements as shares of the skeleton's height, 0 within rounding. The one of
        C is 0 in a clip with a flip.
    mirrored_before, mirrored_after
        Mirrored transitions.
    limbs_changed
        The numbers of frames with bent and straight limbs, and of changed ones.
    """

    clip: str
    frames: int
    limbs: int
    swivels_before: tuple[Jump, ...]
    swivels_after: tuple[Jump, ...]
    backward_before: dict[str, list[int]]
    backward_after: dict[str, list[int]]
    turns_old: tuple[Jump, ...]
    turns_left: tuple[Jump, ...]
    turns_new: tuple[Jump, ...]
    e_moved: float
    c_moved: float
    mirrored_before: tuple[Jump, ...] = ()
    mirrored_after: tuple[Jump, ...] = ()
    limbs_changed: Straightness = field(default_factory=Straightness)

    @property
    def flipped(self) -> bool:
        """Whether the clip had a flip before the correction."""
        return bool(self.swivels_before)

    @property
    def changed_clean(self) -> bool:
        """Whether a limb was changed in a clip without a flip."""
        return not self.flipped and self.c_moved > 0.0

    @property
    def harmed(self) -> bool:
        """Whether the correction did harm."""
        return bool(self.turns_new) or self.e_moved > 0.0 or self.changed_clean or self.changed_bent

    @property
    def changed_bent(self) -> bool:
        """Whether a bent limb was changed in a clip without a flip or a mirrored transition."""
        unlike = self.flipped or self.mirrored_before
        return not unlike and self.limbs_changed.bent_changed > 0

    @property
    def row(self) -> tuple[int, ...]:
        """Return the counts for the table."""
        return (
            len(self.swivels_before),
            len(self.swivels_after),
            sum(map(len, self.backward_before.values())),
            sum(map(len, self.backward_after.values())),
            int(self.changed_clean),
            len(self.turns_old),
            len(self.turns_left),
            len(self.turns_new),
            len(self.mirrored_before),
            len(self.mirrored_after),
            self.limbs_changed.bent_changed,
            self.limbs_changed.straight_changed,
        )


# --- clips --------------------------------------------------------------------------------------


def _mirrored(world: Pose, limb: Limb) -> list[Jump]:
    """Return the mirrored transitions of a limb."""
    bone = _limb_bone(world, limb)
    parent = int(world.motion.skeleton.parents[limb.p])
    above = world.turned[:, parent] if parent >= 0 else np.tile(np.eye(3), (len(bone), 1, 1))
    p, c = world.turned[:, limb.p], world.turned[:, limb.c]
    return [Jump(limb.name, t, d) for t, d in mirrored(above, p, c, bone, world.motion.fps)]


def _changed(before: Pose, after: Pose, limb: Limb) -> Straightness:
    """Count the frames in which a limb is bent or straight, and how many of them changed."""
    bend = bends(*(before.at[:, joint] for joint in (limb.p, limb.c, limb.e)))
    turned = (world.turned[:, limb.p] for world in (before, after))
    return straightness(bend, *turned, _limb_bone(before, limb))


def _limb_bone(world: Pose, limb: Limb) -> Array:
    """Return the direction from P to C in P's coordinates, (frames, 3)."""
    away = unit(world.at[:, limb.c] - world.at[:, limb.p])
    return np.einsum("fji,fj->fi", world.turned[:, limb.p], away)


def judge(clip: str, before: Motion, after: Motion, decimals: int) -> Verdict:
    """Judge one clip before and after correction.

    `decimals` is the number of decimals in the corrected file.
    """
    limbs = find(before)
    worlds = pose(before), pose(after)
    jumps = [tuple(j for limb in limbs for j in swivels(w, limb)) for w in worlds]
    wrong: list[dict[str, list[int]]] = [{}, {}]
    for limb in (limb for limb in limbs if limb.leg):
        own = own_side(worlds[0], limb)
        for world, by_limb in zip(worlds, wrong, strict=True):
            if frames := backward(world, limb, own):
                by_limb[limb.name] = frames
    counter = [tuple(j for limb in limbs for j in _mirrored(w, limb)) for w in worlds]
    old, now = (spins(w, limbs) for w in worlds)
    places = [{(j.of, j.frame) for j in found} for found in (old, now)]
    return Verdict(
        clip=clip,
        frames=before.frames,
        limbs=len(limbs),
        swivels_before=jumps[0],
        swivels_after=jumps[1],
        backward_before=wrong[0],
        backward_after=wrong[1],
        turns_old=tuple(old),
        turns_left=tuple(j for j in old if (j.of, j.frame) in places[1]),
        turns_new=tuple(j for j in now if (j.of, j.frame) not in places[0]),
        e_moved=moved(*worlds, [limb.e for limb in limbs], decimals),
        mirrored_before=counter[0],
        mirrored_after=counter[1],
        limbs_changed=sum((_changed(*worlds, limb) for limb in limbs), Straightness()),
        c_moved=0.0 if jumps[0] else moved(*worlds, [limb.c for limb in limbs], decimals),
    )


def judged_file(path: Path, name: str) -> Verdict:
    """Correct a file and judge it. Raises TwistError if it cannot be corrected or read.

    `name` is the clip's name in the table.
    """
    before = read_bvh(path)
    with tempfile.TemporaryDirectory() as folder:
        output = Path(folder) / "refined.bvh"
        refine_file(path, output)
        after = read_bvh(output)
    return judge(name, before.motion, after.motion, written_decimals(before, after))


def written_decimals(before: Clip, after: Clip) -> int:
    """Return the smallest number of decimals among the changed numbers, or 15 without any."""
    texts = [clip.text[clip.data_start :].split() for clip in (before, after)]
    new = {b for a, b in zip(*texts, strict=False) if a != b}
    return min((len(token.partition(b".")[2]) for token in new), default=15)


# --- the table ----------------------------------------------------------------------------------

HEAD = (
    f"{'swivels':>11} {'backward':>11} {'clean,':>7} {'E moved':>9}  {'impossible turns'}"
    f" {'mirrored':>13} {'changed':>8}",
    f"{'then':>5} {'now':>5} {'then':>5} {'now':>5} {'changed':>7} {'of height':>9}"
    f" {'then':>5} {'left':>5} {'new':>5} {'then':>7} {'now':>5} {'bent':>6} {'straight':>8}",
)
WIDTH = 38  # width of the column with the clips' names
SHOWN = 12  # number of jumps listed for a joint; the JSON contains all


def line(name: str, counts: Sequence[int], e_moved: float) -> str:
    """Return one line of the table. `counts` are those of :attr:`Verdict.row`."""
    first = " ".join(f"{n:>5}" for n in counts[:4])
    last = " ".join(f"{n:>{w}}" for n, w in zip(counts[5:], (5, 5, 5, 7, 5, 6, 8), strict=True))
    share = f"{e_moved:.1e}" if e_moved else "0"
    return f"{name[:WIDTH]:<{WIDTH}} {first} {counts[4]:>7} {share:>9} {last}"


def details(verdict: Verdict) -> list[str]:
    """Return lines with the remaining and the new problems of a clip, with their frames."""
    lists = {
        "swivels left": verdict.swivels_after,
        "new impossible turns": verdict.turns_new,
        "impossible turns left": verdict.turns_left,
        "mirrored transitions left": verdict.mirrored_after,
    }
    told = [f"{verdict.clip}: {what}: {_listed(jumps)}" for what, jumps in lists.items() if jumps]
    for limb, frames in verdict.backward_after.items():
        told.append(f"{verdict.clip}: backward {limb}: {', '.join(_runs(frames))}")
    if verdict.changed_clean:
        told.append(f"{verdict.clip}: C moved by {verdict.c_moved:.1e} of the height")
    return told


def _listed(jumps: Sequence[Jump]) -> str:
    by_name: dict[str, list[str]] = {}
    for jump in jumps:
        by_name.setdefault(jump.of, []).append(f"{jump.frame} ({jump.degrees:+.0f}°)")
    for found in by_name.values():
        found[SHOWN:] = [f"and {len(found) - SHOWN} more"] * (len(found) > SHOWN)
    return "; ".join(f"{name} {', '.join(found)}" for name, found in by_name.items())


def _runs(frames: Sequence[int]) -> list[str]:
    """Return strings such as '12-15' for runs of consecutive frames."""
    parts = np.split(np.array(frames), np.flatnonzero(np.diff(frames) > 1) + 1)
    return [f"{p[0]}" if len(p) == 1 else f"{p[0]}-{p[-1]}" for p in parts]


def table(verdicts: Sequence[Verdict], errors: dict[str, str]) -> str:
    """Return the results of all clips as text.

    The text has the results of each clip, the totals, the remaining problems, and the files that
    could not be judged. `errors` has the reasons for these files, keyed by name.
    """
    total = [sum(column) for column in zip(*(v.row for v in verdicts), strict=True)] or [0] * 12
    lines = [f"{'' if k else 'clip':<{WIDTH}} {head}" for k, head in enumerate(HEAD)]
    lines += [line(v.clip, v.row, v.e_moved) for v in verdicts if any(v.row) or v.e_moved]
    lines.append(line("total", total, max((v.e_moved for v in verdicts), default=0.0)))
    lines += ["", *(text for v in verdicts for text in details(v))]
    lines += [f"{name}: not judged: {error}" for name, error in errors.items()]
    limbs = sum((v.limbs_changed for v in verdicts), Straightness())
    lines.append(
        f"changed: {_share(limbs.bent_changed, limbs.bent)} of the bent limbs' frames, "
        f"{_share(limbs.straight_changed, limbs.straight)} of the straight ones'"
    )
    lines.append(
        f"judged: {len(verdicts)} clips, {sum(v.limbs for v in verdicts)} limbs, "
        f"{sum(v.frames for v in verdicts)} frames; not judged: {len(errors)}"
    )
    return "\n".join(lines)


def _share(some: int, of: int) -> str:
    return f"{some} of {of} ({100.0 * some / max(of, 1):.2f} %)"


def to_json(verdicts: Sequence[Verdict], errors: dict[str, str]) -> str:
    """Return all results as JSON."""
    clips = [asdict(v) | {"changed_clean": v.changed_clean, "harmed": v.harmed} for v in verdicts]
    return json.dumps({"clips": clips, "not_judged": errors}, indent=1) + "\n"


def main() -> int:
    """Judge every clip and print the table. Return 1 if the correction did harm."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--clips", default="*.bvh", metavar="GLOB")
    parser.add_argument("--json", type=Path, metavar="FILE")
    arguments = parser.parse_args()
    paths = sorted(arguments.folder.glob(arguments.clips))
    if not paths:
        parser.error(f"no {arguments.clips} in {arguments.folder}")
    verdicts, errors = [], {}
    for path in paths:
        name = path.relative_to(arguments.folder).with_suffix("").as_posix()
        try:
            verdicts.append(judged_file(path, name))
        except TwistError as error:
            errors[name] = " ".join(str(error).split())
    print(table(verdicts, errors))
    if arguments.json:
        arguments.json.write_text(to_json(verdicts, errors), encoding="utf-8")
    return int(any(v.harmed for v in verdicts))


if __name__ == "__main__":
    sys.exit(main())
