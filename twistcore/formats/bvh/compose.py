"""Write any motion as a new BVH file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from twistcore.errors import TwistError
from twistcore.files.atomic import write_atomically
from twistcore.formats.bvh.numbers import LARGEST
from twistcore.formats.clip import LONGEST, SHORTEST
from twistcore.skeleton.motion import Motion, Skeleton, check_motion
from twistcore.skeleton.rotation import Array, euler_from_quaternion

_ORDER = "ZXY"
_DEEPEST = 100  # maximum number of tabs at the beginning of a line
# Number of rows formatted at a time, because Python's numbers take four times the memory.
_ROWS = 1024
_END = 0.05  # length of an End Site as a share of the skeleton's height


def write_motion(motion: Motion, path: str | Path) -> None:
    """Write a motion as a new BVH file, atomically.

    Reading the file gives the same skeleton, with joints in depth-first order, and the same motion,
    to six decimals of a degree and of the length unit. Joints have ZXY rotations.

    Parameters
    ----------
    motion : Motion
        The motion to write.
    path : str or Path
        The file to write. An existing file is replaced.

    Raises
    ------
    TypeError
        If `motion` is not a Motion.
    TwistError
        If the motion is empty, has a number that is not finite or a joint name that BVH does not
        allow, or if its frame rate is below 1 or above 10,000 frames per second.
    OSError
        If the file cannot be written.

    See Also
    --------
    write_clip : Write a corrected clip in which all other bytes stay the same.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import twistcore as tc
    >>> motion = tc.read_clip("assets/walk.bvh").motion
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     tc.write_motion(motion.sliced(0, 60), Path(folder) / "half_a_second.bvh")
    ...     tc.read_clip(Path(folder) / "half_a_second.bvh")
    <Clip half_a_second.bvh: 60 frames at 120 fps, 31 joints>
    """
    check_motion(motion)
    _check(motion, path)
    write_atomically(Path(path), bvh_text(motion).encode("utf-8", "surrogateescape"))


def bvh_text(motion: Motion) -> str:
    """Return a motion as the text of a BVH file, with ZXY rotations for all joints.

    Roots and joints with position channels have XYZ positions before the rotations. Because many
    programs need End Sites, a joint that has neither a child nor an End Site gets one in the
    direction of its bone. Angles are continuous over time, except for jumps that the range of the
    middle angle makes necessary.
    """
    skeleton = motion.skeleton
    lines, columns, depth = ["HIERARCHY"], [], 0
    positioned, sites = frozenset(motion.positioned), _sites(skeleton)
    todo = [(root, 0) for root in reversed(np.flatnonzero(skeleton.parents < 0).tolist())]
    while todo:
        joint, above = todo.pop()
        lines += _closed(depth, above)
        depth = above + 1
        placed = above == 0 or joint in positioned
        lines += _described(skeleton, joint, above, placed, sites[joint])
        todo += [(child, depth) for child in reversed(skeleton.children[joint])]
        if placed:
            columns.append(np.broadcast_to(motion.translation(joint), (motion.frames, 3)))
        angles = euler_from_quaternion(_ORDER, motion.rotations[:, joint])
        columns.append(np.degrees(np.unwrap(angles, axis=0)))
    lines += _closed(depth, 0)
    rows = np.concatenate(columns, axis=1)
    lines += ["MOTION", f"Frames: {motion.frames}", f"Frame Time: {motion.frame_time:.9g}"]
    form = " ".join(["%.6f"] * rows.shape[1])
    for a in range(0, len(rows), _ROWS):
        lines += [form % tuple(row) for row in rows[a : a + _ROWS].tolist()]
    return "\n".join(lines) + "\n"


def _sites(skeleton: Skeleton) -> list[list[Array]]:
    """Return the offsets of each joint's End Sites."""
    sites: list[list[Array]] = [[] for _ in skeleton.names]
    for owner, site in skeleton.ends:
        sites[owner].append(np.array(site))
    return sites


def _indent(depth: int) -> str:
    """Return the indentation of a line, limited so that deep skeletons do not make huge files."""
    return "\t" * min(depth, _DEEPEST)


def _described(
    skeleton: Skeleton, joint: int, depth: int, placed: bool, sites: list[Array]
) -> list[str]:
    """Return the lines that describe a joint, without the lines of its children.

    `placed` is True if the joint has position channels, and `sites` are the offsets of its End
    Sites.
    """
    indent, offset = _indent(depth), skeleton.offsets[joint]
    channels = "6 Xposition Yposition Zposition" if placed else "3"
    lines = [
        f"{indent}{'JOINT' if depth else 'ROOT'} {skeleton.names[joint]}",
        f"{indent}{{",
        f"{indent}\tOFFSET {_words(offset)}",
        f"{indent}\tCHANNELS {channels} {' '.join(f'{letter}rotation' for letter in _ORDER)}",
    ]
    if not sites and not skeleton.children[joint]:
        length = float(np.linalg.norm(offset))
        tip = offset / length if length > 0.0 else np.array([0.0, 1.0, 0.0])
        sites = [_END * skeleton.height * tip]
    for site in sites:
        lines += [f"{indent}\tEnd Site", f"{indent}\t{{"]
        lines += [f"{indent}\t\tOFFSET {_words(site)}", f"{indent}\t}}"]
    return lines


def _closed(depth: int, to: int) -> list[str]:
    return [_indent(k) + "}" for k in range(depth - 1, to - 1, -1)]


def _words(vector: Array) -> str:
    return " ".join(f"{v:.6f}" for v in vector.tolist())


def _check(motion: Motion, path: str | Path) -> None:
    """Raise TwistError if the motion could not be read back from a BVH file."""
    skeleton = motion.skeleton
    if not len(skeleton) or not motion.frames:
        raise TwistError(f"{path}: expected at least one joint and one frame")
    for what, values in (
        ("OFFSET", skeleton.offsets),
        ("End Site", np.array([offset for _, offset in skeleton.ends])),
        ("rotations", motion.rotations),
        ("positions", motion.positions),
    ):
        good = np.abs(values) < LARGEST
        if not good.all():
            at = tuple(np.argwhere(~good)[0].tolist())
            found = f"found {values[at]:g} at {list(at)}"
            raise TwistError(
                f"{path}: expected finite numbers below {LARGEST:g} for {what}, {found}"
            )
    if not SHORTEST <= motion.frame_time <= LONGEST:
        expected = f"a frame time from {SHORTEST:g} to {LONGEST:g} s"
        raise TwistError(f"{path}: expected {expected}, found {motion.frame_time:g}")
    for name in skeleton.names:
        if name != name.strip() or set(name) & set("{\r\n"):
            raise TwistError(f"{path}: expected a name on one line without '{{', found {name!r}")
