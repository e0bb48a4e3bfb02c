"""Eq. 14-15 in one frame, what is undefined, and the other forms of a rotation."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import ASSETS
from tests.tiers import parametrize
from twistcore.analysis.correction.twist_removal import remove_twist
from twistcore.analysis.decomposition import (
    WhatIf,
    decompose,
    decompose_into_euler_channels,
    detect_and_correct_frame,
    double_cover_twist_angle,
    twist_times_swing_factors,
)
from twistcore.detection.detectors.paper import PaperDetector
from twistcore.detection.paper import DEFAULT_TAU, paper_detector_running_offset
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.rotation import (
    conjugate,
    matrix_from_quaternion,
    multiply,
    normalise,
    quaternion_from_axis_angle,
    quaternion_from_euler,
    rotate,
    swing_twist,
    wrap,
)
from twistcore.skeleton.signals import twist_signals

CLIPS = ("walk_injected", "dance")
CHAINS = ("LeftArm", "LeftForeArm", "RightUpLeg")


@pytest.fixture(scope="module", params=CLIPS)
def clip(request):
    return read_bvh(ASSETS / f"{request.param}.bvh")


@pytest.fixture(scope="module", params=CHAINS)
def chain(request, clip):
    return next(c for c in find_chains(clip.motion) if c.name == request.param)


@parametrize("name", ["LeftForeArm", "RightUpLeg", "RightLeg"])
@parametrize("tau", [np.radians(0.1), DEFAULT_TAU])
def test_err_and_offset_are_the_papers_in_every_frame(name, tau):
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion
    chain = next(c for c in find_chains(motion) if c.name == name)
    signals = twist_signals(motion, chain)
    running = paper_detector_running_offset(
        PaperDetector().analyse(motion, [chain]).signals[name], tau
    )
    total, events = 0.0, 0
    for t in range(motion.frames):
        c = detect_and_correct_frame(motion, chain, t, WhatIf(), tau=tau, offset_before=total)
        p, q = signals.dtheta_p[t], signals.dtheta_c[t]
        m = min(abs(p), abs(q)) if p * q < 0.0 else 0.0
        assert c.err == pytest.approx(np.sign(p) * m if m >= tau else 0.0, abs=1e-12)
        assert c.offset == pytest.approx(running[t], abs=1e-9)
        total, events = c.offset, events + (c.err != 0.0)
    assert events >= (0 if name == "RightLeg" else 4)


def test_the_product_of_both_rotations_stays(clip, chain):
    motion = clip.motion
    for frame in range(0, motion.frames, 25):
        for what_if in (WhatIf(), WhatIf(twist=2.0, counter=True), WhatIf(swing=3.0, bend=0.4)):
            for share in (0.0, 0.3, 1.0):
                c = detect_and_correct_frame(
                    motion, chain, frame, replace(what_if, applied=share), tau=0.02,
                    offset_before=0.7,
                )  # fmt: skip
                before = multiply(c.q_parent, c.q_child)
                after = multiply(c.parent_after, c.child_after)
                assert after == pytest.approx(before, abs=1e-12)  # Eq. 14
                assert c.difference < 1e-12
                # Eq. 15, and P with δ off its own axis.
                child = multiply(multiply(conjugate(c.parent_after), c.q_parent), c.q_child)
                assert c.child_after == pytest.approx(child, abs=1e-12)
                axis = chain.axis if chain.axis.ndim == 1 else chain.axis[frame]
                back = quaternion_from_axis_angle(axis, -c.taken)
                assert c.parent_after == pytest.approx(multiply(c.q_parent, back), abs=1e-12)
                assert c.taken == pytest.approx(share * float(wrap(c.offset)), abs=1e-12)


def test_an_interval_s_offset_is_taken_off_as_the_review_does(clip, chain):
    motion, frame = clip.motion, 60
    offsets = {chain.name: np.full(motion.frames, 0.8)}
    whole = remove_twist(motion, [chain], offsets).rotations[frame]
    c = detect_and_correct_frame(
        motion, chain, frame, WhatIf(applied=1.0), tau=0.02, offset_before=5.0, own=0.8
    )
    for mine, theirs in ((c.parent_after, chain.parent), (c.child_after, chain.child)):
        assert abs(mine @ whole[theirs]) == pytest.approx(1.0, abs=1e-12)
    d = decompose(motion, chain, frame, WhatIf(applied=1.0), offset=c.whole)
    assert wrap(d.theta_p - c.before.theta_p) == pytest.approx(-0.8)


def test_what_is_undefined_is_told(clip, chain):
    def at(**change):
        return decompose(clip.motion, chain, 100, WhatIf(**change))

    usual = at()
    assert usual.n_is_defined
    assert usual.strength_is_defined
    turned = at(swing=np.pi)
    assert not any((turned.swing_is_one, turned.n_is_defined, turned.dtheta_p_is_defined))
    assert turned.dtheta_c_is_defined
    straight = at(bend=0.0)
    assert straight.swing_is_one
    assert not straight.dtheta_c_is_defined
    assert not any((turned.strength_is_defined, straight.strength_is_defined))
    unswung = at(swing=0.0)
    assert unswung.swing_is_one
    assert not unswung.n_is_defined
    for near in (at(swing=np.pi - 0.001), at(bend=0.001)):
        assert near.strength_is_defined
    # What was undefined in the frame before makes the change undefined now.
    rotations = clip.motion.rotations.copy()
    across = normalise(np.cross(usual.a, [0.3, 0.5, 0.8]))
    rotations[99, chain.parent] = quaternion_from_axis_angle(across, np.pi)
    after = decompose(clip.motion.with_rotations(rotations), chain, 100)
    assert after.swing_is_one
    assert not after.dtheta_p_is_defined
    none = detect_and_correct_frame(
        clip.motion, chain, 100, WhatIf(bend=0.0, twist=2.0), tau=0.0, offset_before=0.4
    )
    assert (none.err, none.offset) == (0.0, 0.4)


unit = st.tuples(*(st.floats(-1.0, 1.0) for _ in range(4))).filter(
    lambda v: np.linalg.norm(v) > 0.1
)
direction = st.tuples(*(st.floats(-1.0, 1.0) for _ in range(3))).filter(
    lambda v: np.linalg.norm(v) > 0.1
)


@given(unit, direction)
def test_twist_first_has_the_same_twist_and_another_swing(q, a):
    q, a = normalise(q), normalise(a)
    twist, after = twist_times_swing_factors(q, a)
    swing, same = swing_twist(q, a)
    assert multiply(twist, after) == pytest.approx(q, abs=1e-12)
    assert twist == pytest.approx(same, abs=1e-12)
    assert after[1:] @ a == pytest.approx(0.0, abs=1e-9)  # a swing: no turn about a
    assert after[0] == pytest.approx(swing[0], abs=1e-12)  # by the same angle
    assert rotate(twist, after[1:]) == pytest.approx(swing[1:], abs=1e-12)  # n' turned back


@given(unit, direction)
def test_minus_q_is_the_same_pose_a_full_turn_off(q, a):
    q, a = normalise(q), normalise(a)
    same = matrix_from_quaternion(-q)
    assert np.array_equal(matrix_from_quaternion(q), same)
    apart = abs(double_cover_twist_angle(q, a) - double_cover_twist_angle(-q, a))
    if np.hypot(q[0], q[1:] @ a) > 1e-9:
        assert apart == pytest.approx(2.0 * np.pi)
        left = double_cover_twist_angle(q, a) - double_cover_twist_angle(
            -q, a
        )  # ±180° are one angle
        assert wrap(left) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("order", ["ZYX", "XYZ", "ZXY", "YZX"])
@pytest.mark.parametrize("middle", [-95.0, -88.0, -20.0, 0.0, 50.0, 86.0, 90.0, 92.0])
def test_channels_mean_the_pose_and_the_lock_is_where_two_axes_meet(order, middle):
    written = np.radians([33.0, middle, -71.0])
    q = quaternion_from_euler(order, written)
    found = decompose_into_euler_channels(order, q, written)
    assert found.angles == pytest.approx(written, abs=1e-6)
    axes = np.eye(3)["XYZ".index(order[0])], np.eye(3)["XYZ".index(order[2])]
    last = rotate(quaternion_from_euler(order[:2], written[:2]), axes[1])
    between = np.arccos(min(abs(float(axes[0] @ last)), 1.0))
    assert found.between == pytest.approx(between, abs=1e-6)
    assert found.locked == (abs(abs(middle) - 90.0) < 4.99)


def test_channels_of_a_captured_frame_are_the_files(clip, chain):
    for joint in (chain.parent, chain.child):
        layout = clip.channels[joint]
        for frame in range(0, clip.motion.frames, 40):
            written = np.radians(clip.values[frame, list(layout.rotation)])
            q = clip.motion.rotations[frame, joint]
            assert decompose_into_euler_channels(layout.order, q, written).angles == pytest.approx(
                written, abs=1e-7
            )
