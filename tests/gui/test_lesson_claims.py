"""What the lessons say is so: every page's claims by numbers of the clips that it shows.

A claim gives the numbers that the page may have; a page with another number fails.
"""

import re
from functools import cache

import numpy as np
import pytest

from benchmarks import lesson_clip
from inspector.bundled import ASSETS, LESSONS, SAMPLE
from inspector.lessons.lesson_file import read_lesson
from inspector.session.opening import analyse_clip
from tests.gui.test_tour import ALL, TRANSLATED
from twistcore.analysis.correction.twist_removal import refine
from twistcore.analysis.decomposition import WhatIf, decompose, frame_motion_with_user_changes
from twistcore.detection import Kind
from twistcore.detection.paper import paper_detector_running_offset
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.motion import forward_kinematics
from twistcore.skeleton.rotation import (
    conjugate,
    geodesic_angle,
    multiply,
    quaternion_from_axis_angle,
    rotate,
)

_NUMBER = re.compile(r"(?<![\w.])[−-]?\d+(?:\.\d+)?")
_NOT_A_FACT = re.compile(r"(Eq|Gl)\. \d+( (to|bis|,) \d+)?|\$[^$]*\$|\b3D\b")
_ARM, _AT = "LeftArm", 200
_LEG, _START, _STOP = "RightUpLeg", 59, 74
_WITHIN = 66
_PERSON = 170.0  # cm


@cache
def clip(name=SAMPLE.name):
    return analyse_clip(read_bvh(ASSETS / name))


def chain(name):
    return next(c for c in clip().chains if c.name == name)


def at(name, frame, offset=0.0, stage=None, **what_if):
    turned = {k: np.radians(v) for k, v in what_if.items() if k not in ("counter", "applied")}
    plain = {k: v for k, v in what_if.items() if k in ("counter", "applied")}
    altering = WhatIf(**turned, **plain)
    return decompose(clip().motion, chain(name), frame, altering, offset=offset, stage=stage)


def moved(name, frame, offset=0.0, **what_if):
    """How far P, C and G go by a what-if, cm on a person of 170 cm."""
    turned = {k: np.radians(v) for k, v in what_if.items() if k not in ("counter", "applied")}
    plain = {k: v for k, v in what_if.items() if k in ("counter", "applied")}
    one = frame_motion_with_user_changes(
        clip().motion, chain(name), frame, WhatIf(**turned, **plain), offset=offset
    )
    there = forward_kinematics(one)[1][0]
    here = clip().positions[frame]
    joints = [getattr(chain(name), j) for j in ("parent", "child", "grandchild")]
    height = np.ptp(clip().positions[0], axis=0).max()
    return np.linalg.norm(there[joints] - here[joints], axis=1) / height * _PERSON


def deg(angle, digits=0):
    return f"{np.degrees(angle):.{digits}f}".replace("-", "−")


def opposed(name):
    s = clip().signals[name]
    return s.dtheta_p * s.dtheta_c < 0.0


# -- claims that more than one page makes ---------------------------------------------------------


def pure_twist():
    captured, twisted = at(_ARM, _AT), at(_ARM, _AT, twist=75.0)
    for same in ("w", "n", "alpha", "v"):
        assert np.allclose(getattr(captured, same), getattr(twisted, same), atol=1e-9)
    assert np.isclose(twisted.theta_p - captured.theta_p, np.radians(75.0))
    assert abs(np.degrees(twisted.dtheta_c)) < 0.001
    p, c, g = moved(_ARM, _AT, twist=75.0)
    assert max(p, c) < 1e-9
    axis, joints = captured.w, [getattr(chain(_ARM), j) for j in ("child", "grandchild")]
    turned = [WhatIf(twist=np.radians(a)) for a in (0.0, 30.0, 75.0, 180.0)]
    poses = [frame_motion_with_user_changes(clip().motion, chain(_ARM), _AT, one) for one in turned]
    arms = np.array([np.diff(forward_kinematics(p)[1][0][joints], axis=0)[0] for p in poses])
    assert np.ptp(np.linalg.norm(arms, axis=1)) < 1e-6  # the wrist is on a circle about the bone:
    above = clip().motion.skeleton.parents[chain(_ARM).parent]
    world = rotate(clip().rotations[_AT, above], axis)
    assert np.ptp(arms @ world) < 1e-6
    return {"60", "75", "170", f"{g:.0f}"}


def rounding():
    """A pure twist with a product below zero: why there is a τ."""
    assert at(_ARM, _AT, twist=75.0).product < 0.0
    assert at(_ARM, _AT, twist=60.0).product < 0.0
    s, natural = clip().signals[_ARM], opposed(_ARM)
    m = np.minimum(np.abs(s.dtheta_p), np.abs(s.dtheta_c))[natural]
    assert np.degrees(m.max()) < 0.001
    tau = clip().review.state.tau[_ARM]
    assert m.max() < tau
    shares = [opposed(c.name).mean() for c in clip().chains if opposed(c.name).any()]
    assert min(shares) > 0.4
    assert max(shares) < 0.6  # every second frame
    return {"0.001", f"{100 * natural.mean():.0f}", "100", "60", deg(tau, 1)}


def counter_twist():
    d = at(_ARM, _AT, twist=75.0, counter=True)
    assert d.product < 0.0
    assert max(moved(_ARM, _AT, twist=75.0, counter=True)) < 0.1
    assert moved(_ARM, _AT, twist=75.0)[2] > 10.0  # G ideal is elsewhere
    assert np.isclose(d.strength, np.radians(75.0), atol=1e-4)
    assert np.isclose(d.dtheta_c, np.radians(-75.0), atol=1e-4)  # what the twist did, not θp
    assert abs(d.dtheta_p + d.dtheta_c) > np.radians(0.1)
    assert np.isclose(d.strength, min(abs(d.dtheta_p), abs(d.dtheta_c)))
    return {deg(d.dtheta_c), "75"}


def swing_keeps_the_roll():
    captured = at(_ARM, _AT)
    for angle in (90.0, 120.0, 135.0, 170.0):
        swung = at(_ARM, _AT, swing=angle)
        assert np.isclose(swung.theta_p, captured.theta_p)
        assert np.isclose(swung.alpha, np.radians(angle))
        assert np.allclose(swung.n, captured.n, atol=1e-9)
        assert abs(float(swung.n @ swung.a)) < 1e-9
        assert abs(float(swung.n @ swung.w)) < 1e-9
        for other in (0.0, 30.0, -90.0):  # a roll added to the swing makes the turn longer
            roll = quaternion_from_axis_angle(swung.w, np.radians(other))
            turn = 2.0 * np.arccos(min(abs(float(multiply(roll, swung.swing)[0])), 1.0))
            assert turn >= swung.alpha - 1e-9
    return {"120"}


def swing_alone():
    whole, part = at(_ARM, _AT), at(_ARM, _AT, stage=1.0)
    assert np.allclose(whole.w, part.w, atol=1e-9)
    assert abs(part.theta_p) < 1e-9
    half = whole.alpha / 2.0
    expected = [np.cos(half), *(np.sin(half) * whole.n)]
    assert np.allclose(whole.swing, expected, atol=1e-9)  # Eq. 6
    assert np.isclose(np.degrees(whole.theta_p), 34.0, atol=0.5)
    return {deg(part.theta_p + 1e-12), deg(whole.theta_p)}


def first_jump():
    before, jump, after = (at(_LEG, _START + k) for k in (-1, 0, 1))
    assert before.strength < np.radians(0.01)
    assert after.strength < np.radians(0.01)
    assert jump.product < 0.0
    p = clip().positions
    foot, height = chain(_LEG).grandchild, np.ptp(p[0], axis=0).max()
    step = np.linalg.norm(np.diff(p[_START - 2 : _START + 2, foot], axis=0), axis=1)
    assert np.ptp(step) / height * _PERSON < 0.2  # it goes on as it did
    clean = clip("walk.bvh").positions
    assert np.abs(p - clean).max() / height < 1e-6  # every joint is where it was
    return {deg(jump.dtheta_p), f"+{deg(jump.dtheta_c)}", deg(jump.dtheta_c)}


def second_jump():
    jump, last = at(_LEG, _STOP), at(_LEG, _STOP - 1)
    assert last.strength < np.radians(0.01)
    assert jump.product < 0.0
    found = [j.interval for j in clip().review.state.intervals if j.interval.chain == _LEG]
    assert (_START, _STOP) in {(i.start, i.stop) for i in found}
    inside = np.degrees(clip().signals[_LEG].theta_p[_START:_STOP])
    outside = np.degrees(clip("walk.bvh").signals[_LEG].theta_p[_START - 3 : _START])
    assert np.abs(inside + 170.0).max() < 5.0
    assert np.abs(outside + 10.0).max() < 5.0
    clean = clip("walk.bvh").motion.rotations[_START:_STOP, chain(_LEG).parent]
    wrong = clip().motion.rotations[_START:_STOP, chain(_LEG).parent]
    assert np.degrees(geodesic_angle(wrong, clean)).min() > 150.0  # every pose of them
    return {"−170", "−10", f"{_STOP - _START}", deg(jump.dtheta_p), deg(jump.dtheta_c)}


def only_at_errors():
    s, tau = clip().signals[_LEG], clip().review.state.tau[_LEG]
    truth = [j.interval for j in clip().review.state.intervals if j.interval.chain == _LEG]
    edges = {e for i in truth for e in (i.start, i.stop)}
    m = np.where(opposed(_LEG), np.minimum(abs(s.dtheta_p), abs(s.dtheta_c)), 0.0)
    assert set(np.flatnonzero(m >= tau)) == edges
    return set()


def smaller_of_two():
    d = at(_LEG, _START)
    assert d.strength == min(abs(d.dtheta_p), abs(d.dtheta_c))
    clean = clip("walk.bvh").signals[_LEG].dtheta_p[_START]
    assert np.isclose(d.dtheta_p + d.dtheta_c, clean, atol=1e-4)  # its own movement
    return {deg(d.dtheta_p, 1), deg(d.dtheta_c, 1), deg(d.strength, 1)}


def offset_at(frame):
    return float(
        paper_detector_running_offset(clip().signals[_LEG], clip().review.state.tau[_LEG])[frame]
    )


def level_shift():
    inside = [offset_at(t) for t in range(_START, _STOP)]
    assert np.ptp(inside) == 0.0  # err(t) is 0 between the jumps
    left = offset_at(_STOP) - offset_at(_START - 1)  # by this pair, not by the errors before it
    assert abs(left) < 0.1 * abs(offset_at(_STOP))
    events = [t for t in range(1, _START) if offset_at(t) != offset_at(t - 1)]
    assert len(events) == 2  # one earlier error of this leg, which leaves the sum off zero
    found = [j.interval for j in clip().review.state.intervals if j.interval.chain == _LEG]
    assert tuple(events) in {(i.start, i.stop) for i in found}
    assert np.isclose(offset_at(_START - 1), offset_at(_STOP), rtol=0.1)
    sums = {deg(inside[0]), deg(offset_at(_STOP), 1), deg(left, 3)}
    return {"0", *sums, f"{_STOP - _START}", "10"}


def apply():
    """At the jump, so that the frame before is right."""
    offset, now = offset_at(_START), _START
    wrong, right = at(_LEG, now), at(_LEG, now, offset=offset, applied=1.0)
    assert wrong.strength > np.radians(150.0)
    assert right.strength < clip().review.state.tau[_LEG]
    before = at(_LEG, now - 1)
    assert round(np.degrees(before.theta_p - right.theta_p)) == 0
    assert max(moved(_LEG, now, offset=offset, applied=1.0)) < 1e-6
    motion, c = clip().motion, chain(_LEG)
    one = frame_motion_with_user_changes(motion, c, now, WhatIf(applied=1.0), offset=offset)
    poses = [m.rotations[k] for m, k in ((motion, now), (one, 0))]
    shins = [multiply(q[c.parent], q[c.child]) for q in poses]
    assert float(geodesic_angle(*shins)) < 1e-9  # Eq. 14
    # P alone would turn the shin and the foot along; the knee is on the axis and stays.
    _, knee, foot = moved(_LEG, now, twist=float(np.degrees(-offset)))
    assert knee < 1e-6
    assert foot > 1.0
    return {deg(wrong.theta_p), deg(right.theta_p), deg(offset)}


def corrected():
    """As the interval of the review is taken off."""
    (one,) = [
        j.interval
        for j in clip().review.state.intervals
        if j.interval.chain == _LEG and j.interval.start <= _WITHIN < j.interval.stop
    ]
    offset = float(one.offset[_WITHIN - one.start])
    assert max(moved(_LEG, _WITHIN, offset=offset, applied=1.0)) < 1e-6
    pose = frame_motion_with_user_changes(
        clip().motion, chain(_LEG), _WITHIN, WhatIf(applied=1.0), offset=offset
    )
    clean = clip("walk.bvh").motion.rotations[_WITHIN]
    assert np.degrees(geodesic_angle(pose.rotations[0], clean)).max() < 0.2
    return {"0.2"}


def blind_spots():
    plus, minus = (at(_ARM, _AT, swing=179.0, nudge=n) for n in (1.0, -1.0))
    assert abs(np.degrees(plus.theta_p - minus.theta_p)) > 90.0
    straight, nudged = (at(_ARM, _AT, bend=1.0, nudge=n) for n in (0.0, 1.0))
    assert straight.azimuth_reliability < 0.02
    assert np.isclose(straight.azimuth_reliability, np.linalg.norm(straight.across))
    against = at(_ARM, _AT, swing=180.0)  # one pose, many pairs: as n turns by φ, θp turns by 2φ
    for turned in (20.0, 70.0):
        n = rotate(quaternion_from_axis_angle(against.a, np.radians(turned)), against.n)
        twist = quaternion_from_axis_angle(against.a, against.theta_p + 2.0 * np.radians(turned))
        pose = multiply(quaternion_from_axis_angle(n, np.pi), twist)
        assert float(geodesic_angle(pose, against.q)) < 1e-6
    return {"180", "0", "1", deg(nudged.dtheta_c)}


def the_skin_is_wrung():
    assert _START <= 52 + 12 < _STOP
    seconds = (_STOP - _START) / clip().motion.fps
    assert np.isclose(seconds, 1 / 8, atol=0.005)  # an eighth of a second
    return first_jump() | {"12"}


def the_axis():
    a = chain(_ARM).axis
    assert a.shape == (3,)  # one for all frames
    assert np.isclose(np.linalg.norm(a), 1.0)
    d = at(_ARM, _AT)
    assert np.allclose(multiply(d.swing, d.twist), d.q, atol=1e-12)
    return set()


def the_twist():
    d = at(_ARM, _AT)
    assert np.allclose(np.cross(d.twist[1:], d.a), 0.0, atol=1e-9)
    other = multiply(d.q, conjugate(d.swing))  # as printed: a roll about w by the same angle
    assert np.allclose(np.cross(other[1:], d.w), 0.0, atol=1e-9)
    assert np.isclose(other[0], d.twist[0])
    assert not np.allclose(other, d.twist, atol=1e-3)
    return the_axis()


def it_comes_round():
    below, beyond = at(_ARM, _AT, twist=140.0), at(_ARM, _AT, twist=150.0)
    assert below.theta_p > 0.0 > beyond.theta_p
    assert abs(np.degrees(beyond.dtheta_p)) < 180.0
    return {"150", "180", "−180", "360"}


def across_the_axis():
    d = at(_ARM, _AT)
    assert abs(float(d.across @ d.a)) < 1e-9
    assert np.allclose(d.across, d.v - (d.v @ d.a) * d.a)
    return set()


def to_decide():
    found = [j.interval for j in clip().review.state.intervals]
    (one,) = [i for i in found if i.chain == _LEG and i.start <= _WITHIN < i.stop]
    assert one.kind == Kind.COUNTER_TWIST
    tour = read_lesson(LESSONS / "tour.md").pages[6].place
    assert tour.look == "both"
    assert tour.skin  # the page speaks of a stripe
    return set()


def the_captures_own():
    flips = [j.interval for j in clip("kick.bvh").review.state.intervals]
    (flip,) = (i for i in flips if i.kind == Kind.LIMB_FLIP and i.start <= 48 < i.stop)
    captured = clip("kick.bvh")
    limb = next(c for c in captured.chains_and_limbs if c.name == flip.chain)
    right = refine(captured.motion, captured.chains_and_limbs, [flip])
    now, before = forward_kinematics(right)[1][48], captured.positions[48]
    p, c, e = limb.parent, limb.child, limb.end
    height = np.ptp(before, axis=0).max()
    assert np.linalg.norm(now[[p, e]] - before[[p, e]], axis=1).max() < 1e-6 * height
    assert np.linalg.norm(now[c] - before[c]) > 0.05 * height  # the knee is on the other side
    apart = [np.linalg.norm(x[c] - x[[p, e]], axis=1) for x in (now, before)]
    assert np.allclose(*apart, atol=1e-6 * height)  # on the circle about the line
    return set()


# -- the noisy walk -------------------------------------------------------------------------------

_NOISY = "walk_noisy.bvh"


def noisy_counts():
    """The number of intervals of the paper's detector, keyed by τ in degrees."""
    paper = clip(_NOISY).analysis.by("paper")
    taus = (0.5, 1.5, 2.0, 3.0, 4.0, 8.0, 20.0)
    return {tau: len(paper.intervals(lesson_clip.NOISY, np.radians(tau))) for tau in taus}


def noise_like_errors():
    motion = lesson_clip.lesson_motion(clip("walk.bvh").motion)
    assert geodesic_angle(motion.rotations, clip(_NOISY).motion.rotations).max() < 1e-6
    s = clip(_NOISY).signals[lesson_clip.NOISY]
    m = np.minimum(np.abs(s.dtheta_p), np.abs(s.dtheta_c)) * (s.dtheta_p * s.dtheta_c < 0.0)
    edges = [edge for start, stop, _ in lesson_clip.TWISTS for edge in (start, stop)]
    assert 4.0 < np.degrees(m[edges].min()) < 5.0
    assert np.argmin(m[edges]) < 2  # at the smallest error
    noise = np.delete(m, edges).max()
    assert noise < np.radians(1.5)
    sizes = {f"{abs(degrees):g}" for *_, degrees in lesson_clip.TWISTS}
    return sizes | {f"{lesson_clip.SIGMA:g}", deg(noise, 1)}


def too_low():
    counts = noisy_counts()
    assert (counts[2.0], counts[0.5]) == (3, 10)
    return {"2", "0.5"}


def too_high():
    counts = noisy_counts()
    assert (counts[8.0], counts[20.0]) == (2, 1)
    return {"8", "20", "5"}


def plateau():
    counts = noisy_counts()
    assert counts[1.5] == counts[2.0] == counts[3.0] == counts[4.0] == 3
    starts = {(start, stop) for start, stop, _ in lesson_clip.TWISTS}
    paper = clip(_NOISY).analysis.by("paper")
    for tau in (1.5, 4.0):
        found = paper.intervals(lesson_clip.NOISY, np.radians(tau))
        assert {(i.start, i.stop) for i in found} == starts
    return {"1.5", "4"}


def a_success():
    """And the paper's figures, from its section 4.2 [Choi26]."""
    signals = clip(_NOISY).signals[lesson_clip.NOISY]
    removed = (
        np.degrees(paper_detector_running_offset(signals, np.radians(2.0))[275])
        / lesson_clip.TWISTS[2][2]
    )
    assert removed >= 0.8
    return {"80", f"{100 * removed:.0f}", "70", "94.81", "335004"}


def straight_thigh():
    d = [
        decompose(clip(_NOISY).motion, chain(_LEG), 200, WhatIf(bend=np.radians(1.0), nudge=n))
        for n in (0.0, np.radians(1.0))
    ]
    assert d[0].azimuth_reliability < 0.02
    assert abs(np.degrees(d[1].dtheta_c - d[0].dtheta_c)) > 20.0
    return {"98", "80", "0", "1"}


def carried_roll():
    start, stop, degrees = lesson_clip.ROLL
    found = [j.interval for j in clip(_NOISY).review.state.intervals]
    (roll,) = (i for i in found if i.kind == Kind.CARRIED_ROLL)
    assert (roll.chain, roll.start, roll.stop) == (lesson_clip.ROLLED, start, stop)
    size = np.ptp(clip(_NOISY).positions[0], axis=0).max()
    clean = refine(clip(_NOISY).motion, clip(_NOISY).chains, found)
    there, here = forward_kinematics(clean)[1], clip(_NOISY).positions
    own = [getattr(chain(lesson_clip.ROLLED), j) for j in ("parent", "child", "grandchild")]
    assert np.abs(there[start:stop, own] - here[start:stop, own]).max() < 1e-6 * size
    right = clip("walk.bvh").motion.rotations[start:stop, own]
    assert np.degrees(geodesic_angle(clean.rotations[start:stop, own], right)).max() < 0.1
    return {deg(np.radians(degrees)), "3"}


def two_witnesses():
    start, _, degrees = lesson_clip.ROLL
    now = decompose(clip(_NOISY).motion, chain(lesson_clip.ROLLED), start, WhatIf())
    assert now.product < 0.0
    assert abs(np.degrees(now.dtheta_p) - degrees) < 1.0
    return carried_roll() | {deg(now.dtheta_c), "0"}


CLAIMS = {
    "4-2-threshold": [
        (noise_like_errors, too_low),
        (too_high,),
        (plateau,),
        (a_success,),
        (straight_thigh,),
    ],
    "5-beyond-the-paper": [
        (carried_roll,),
        (two_witnesses,),
        (carried_roll,),
        (the_captures_own,),
    ],
    "tour": [
        (the_skin_is_wrung,),
        (the_axis,),
        (swing_keeps_the_roll,),
        (pure_twist, rounding),
        (counter_twist,),
        (blind_spots,),
        (to_decide, first_jump),
        (the_captures_own,),
    ],
    "3-1-definition": [
        (pure_twist,),
        (counter_twist,),
        (first_jump,),
        (second_jump,),
    ],
    "3-2-extraction": [
        (the_axis,),
        (swing_keeps_the_roll,),
        (swing_alone,),
        (the_twist,),
        (it_comes_round,),
        (across_the_axis,),
        (pure_twist, counter_twist, swing_alone),
        (blind_spots,),
    ],
    "3-3-refinement": [
        (smaller_of_two,),
        (rounding,),
        (level_shift,),
        (apply,),
        (corrected,),
    ],
    "lecture": [
        (the_skin_is_wrung,),
        (pure_twist,),
        (counter_twist,),
        (swing_keeps_the_roll, the_axis),
        (swing_alone,),
        (across_the_axis, pure_twist, counter_twist),
        (first_jump, second_jump, only_at_errors),
        (rounding, smaller_of_two),
        (apply, level_shift),
        (blind_spots, to_decide),
    ],
}


def pages():
    for path in (*ALL, *TRANSLATED):
        language = "" if path in ALL else f"-{path.parent.name}"
        for number, page in enumerate(read_lesson(path).pages):
            yield pytest.param(path.stem, number, page, id=f"{path.stem}{language}-{number + 1}")


@pytest.mark.parametrize(("lesson", "number", "page"), list(pages()))
def test_every_number_of_a_page_is_computed(lesson, number, page):
    confirmed = set().union(*(claim() for claim in CLAIMS[lesson][number]))
    text = _NOT_A_FACT.sub("", f"{page.body} {page.task}").replace("+", "")
    told = {n.lstrip("+").replace("-", "−") for n in _NUMBER.findall(text)}
    assert told <= {n.lstrip("+") for n in confirmed}


def test_every_page_has_its_claims():
    for path in ALL:
        assert len(CLAIMS[path.stem]) == len(read_lesson(path).pages)
    assert CLAIMS.keys() == {path.stem for path in ALL}
    assert LESSONS.is_dir()
