"""An exercise's clip is the motion with its errors, and its numbers do not tell where those are."""

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.formats.bvh import parse_bvh, read_bvh
from twistcore.formats.clip import changed_rotations
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import geodesic_angle
from twistcore.study.exercise import hide_exercise_errors
from twistcore.study.exercise_clip import decimals_of_written_angles, write_student_exercise_clip

WALK = read_bvh(ASSETS / "walk.bvh")


def in_other_words(word):
    """The walk with its numbers written otherwise."""
    rows = "\n".join(" ".join(word % v for v in row) for row in WALK.values.tolist())
    return parse_bvh(WALK.data[: WALK.token_spans[0][0]] + rows.encode() + b"\n", "walk.bvh")


@pytest.mark.parametrize(
    ("word", "decimals"), [("%.4f", 3), ("%.7f", 3), ("%.6g", 3), ("%.2f", 2), ("%.1f", 1)]
)
def test_nothing_about_its_decimals_tells_an_error(tmp_path, word, decimals):
    clip, path = in_other_words(word), tmp_path / "a.bvh"
    dirty, errors = hide_exercise_errors(clip.motion, find_chains(clip.motion), 5)
    write_student_exercise_clip(clip, dirty, path)
    written = read_bvh(path)
    words = [line.split() for line in path.read_text().splitlines()[-len(clip.values) :]]
    turns = np.array([layout.rotation for layout in clip.channels])
    changed = changed_rotations(clip, dirty)
    assert changed.sum() >= sum(e.stop - e.start for e in errors)
    tokens = np.array(words)[:, turns]
    assert {len(token.partition(".")[2]) for token in tokens.ravel()} == {decimals}
    assert not np.any(np.strings.startswith(tokens, "-0.") & (tokens.astype(float) == 0.0))
    # Nor do zeros at the end: of the angles that move by themselves, changed and not.
    moving = np.ptp(clip.values[1:, turns], axis=0) > 0.0
    ends, changed = np.strings.endswith(tokens, "0"), changed[..., None] & moving
    natural = ends[1:, moving & changed.any(axis=0)][~changed[1:, moving & changed.any(axis=0)]]
    assert natural.mean() == pytest.approx(ends[changed].mean(), abs=0.06)
    # It is the motion all the same.
    apart = geodesic_angle(written.motion.rotations, dirty.rotations)
    assert np.degrees(apart).max() < 2.0 * 10.0**-decimals
    assert np.allclose(written.motion.positions, dirty.positions, atol=1e-5)


def test_a_joint_that_stands_still_does_not_count():
    moving = np.round(np.random.default_rng(1).uniform(-180.0, 180.0, 4000), 4)
    assert (
        decimals_of_written_angles(np.concatenate([moving, np.full(9000, 90.0), np.zeros(9000)]))
        == 3
    )
    assert decimals_of_written_angles(np.zeros(5)) == 3
    assert decimals_of_written_angles(np.arange(-90.0, 90.0)) == 0
