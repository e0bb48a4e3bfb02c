"""Each claim of the words in the teaching tab, held against the numbers."""

import re
from dataclasses import replace

import numpy as np
import pytest

from inspector.session.document import Document
from inspector.session.opening import analyse_file
from inspector.teaching.taught_frame import TaughtFrame
from inspector.teaching.what_if_words import (
    azimuth_change_per_tilt,
    theta_change_per_tilt,
    what_if_comment,
)
from inspector.widgets.theme import DARK
from tests.conftest import ASSETS
from tests.gui.windows import act
from twistcore.analysis.decomposition import WhatIf, decompose
from twistcore.skeleton.rotation import (
    geodesic_angle,
    multiply,
    quaternion_from_axis_angle,
    rotate,
    wrap,
)

ONE_WINDOW = True
DEGREE = np.radians(1.0)
PI = np.pi


@pytest.fixture
def taught(qapp):
    document = Document()
    document.show_clip(analyse_file(ASSETS / "walk_injected.bvh"))
    document.select_chain("LeftArm")
    document.go_to(90)
    frame = TaughtFrame(document)
    frame.set_active(True)
    yield frame
    document.close_clip()
    document.deleteLater()


def told(taught, **change):
    """The words on the frame altered so."""
    what_if = WhatIf(**change)
    taught.set_what_if(what_if)
    return what_if_comment(taught.numbers, what_if, taught.stage)[0]


def numbers_in(text):
    return [float(x) for x in re.findall(r"[+-]?\d+(?:\.\d+)?", text.replace("−", "-"))]


def test_captured_and_quiet_it_invites(taught):
    assert told(taught)


def test_a_pure_twist_changes_the_twist_alone(taught):
    still = taught.quantities
    told(taught, twist=1.0)
    d = taught.quantities
    assert wrap(d.theta_p - still.theta_p) == pytest.approx(1.0)
    for name in ("w", "n", "alpha", "dtheta_c"):
        assert getattr(d, name) == pytest.approx(getattr(still, name), abs=1e-9)
    assert d.strength < taught.tau


def test_a_small_opposed_change_is_why_there_is_a_threshold(taught):
    taught.document.select_chain("RightLeg")
    strength = taught.document.data.signals["RightLeg"].strength
    opposed = np.flatnonzero((strength > np.radians(0.05)) & (strength < taught.tau))
    taught.document.go_to(int(opposed[0]))
    text = told(taught)
    d = taught.quantities
    assert d.product < 0.0
    m, tau = numbers_in(text)[:2]
    assert m == pytest.approx(np.degrees(d.strength), abs=0.006)
    assert tau == pytest.approx(np.degrees(taught.tau), abs=0.06)
    assert m < tau
    # The same beside a pure twist whose sign happens to be the other.
    twist = -np.sign(d.dtheta_c) * 0.5
    text = told(taught, twist=twist)
    d = taught.quantities
    assert d.product < 0.0
    assert d.strength == pytest.approx(abs(d.dtheta_c))
    assert not taught.numbers.is_event


def test_a_counter_twist_turns_only_p_and_leaves_c_and_g(taught):
    still, rest = taught.document.pose(90, after=False)
    text = told(taught, twist=1.0, counter=True)
    rotations, positions = taught.pose()
    chain = taught.chain
    below = [chain.child, chain.grandchild]
    assert positions[below] == pytest.approx(rest[below], abs=1e-9)
    assert geodesic_angle(rotations[below], still[below]).max() < 1e-9
    assert geodesic_angle(rotations[chain.parent], still[chain.parent]) == pytest.approx(1.0)
    m, tau = numbers_in(text)[:2]
    assert m == pytest.approx(np.degrees(taught.quantities.strength), abs=0.06)
    assert m >= tau


def test_near_half_a_turn_the_papers_test_is_blind(taught):
    text = told(taught, twist=np.radians(-179.8), counter=True)
    d = taught.quantities
    assert text
    assert d.product > 0.0
    assert d.strength == 0.0
    assert taught.numbers.correction.err == 0.0


def test_an_event_says_what_goes_into_the_offset(taught):
    document = taught.document
    document.select_chain("LeftForeArm")
    judged = next(j for j in document.intervals if j.interval.chain == "LeftForeArm")
    document.go_to(judged.interval.start)
    text = told(taught)
    c = taught.numbers.correction
    m, tau, err = numbers_in(text)[:3]
    assert m >= tau
    assert err == pytest.approx(np.degrees(c.err), abs=0.06)
    assert c.offset == c.offset_before + c.err
    # Applied: of the running sum, or of the interval's own once that is selected.
    assert "of offset(t) = " in told(taught, applied=1.0)
    document.select_interval(judged.id)
    text = told(taught, applied=0.6)
    share, whole, was, left, *_ = numbers_in(text)
    assert share == 60.0
    assert whole == pytest.approx(np.degrees(judged.interval.offset[0]), abs=0.06)
    assert was == pytest.approx(np.degrees(taught.numbers.correction.before.strength), abs=0.06)
    assert left == pytest.approx(np.degrees(taught.quantities.strength), abs=0.06)
    assert left < was
    assert taught.numbers.correction.difference < 1e-12


def test_one_pose_has_many_swings_and_twists_at_half_a_turn(taught):
    text = told(taught, swing=PI)
    assert "Many pairs (n, θp)" in text
    d = taught.quantities
    assert rotate(d.q, d.a) == pytest.approx(-d.a, abs=1e-9)
    for theta in np.radians((-150.0, -40.0, 0.0, 77.0)):
        twist = quaternion_from_axis_angle(d.a, theta)
        swing = multiply(d.q, twist * np.array([1.0, -1.0, -1.0, -1.0]))
        # A turn by 180° about an axis across the bone: as good a swing as any other.
        assert swing[0] == pytest.approx(0.0, abs=1e-9)
        assert swing[1:] @ d.a == pytest.approx(0.0, abs=1e-9)
        assert multiply(swing, twist) == pytest.approx(d.q, abs=1e-12)
    told(taught, swing=PI, nudge=DEGREE)
    assert taught.quantities.swing_is_one


@pytest.mark.parametrize("degrees", [169.0, 172.0, 176.0, 179.0])
def test_what_a_tip_of_a_degree_does_to_theta_is_so(taught, degrees):
    alpha = np.radians(degrees)
    text = told(taught, swing=alpha)
    near = taught.quantities
    said = numbers_in(text)
    assert said[0] == pytest.approx(100.0 * near.swing_reliability, abs=0.51)
    taught.alter(nudge=DEGREE)
    moved = abs(float(wrap(taught.quantities.theta_p - near.theta_p)))
    assert theta_change_per_tilt(alpha) == pytest.approx(moved, rel=0.03)
    assert said[2] == pytest.approx(np.degrees(moved), rel=0.08)


@pytest.mark.parametrize("degrees", [1.0, 4.0, 9.0, 175.0])
def test_what_a_tip_of_a_degree_does_to_the_azimuth_is_so(taught, degrees):
    text = told(taught, bend=np.radians(degrees))
    near = taught.quantities
    assert ("straight" if degrees < 90.0 else "folded") in text
    taught.alter(nudge=DEGREE)
    moved = abs(float(wrap(taught.quantities.dtheta_c - near.dtheta_c)))
    assert azimuth_change_per_tilt(near.azimuth_reliability) == pytest.approx(moved, rel=0.03)


def test_both_singularities_turn_their_axes_much_at_a_nudge(taught):
    at = {"swing": np.radians(168.6), "bend": np.radians(9.7)}
    assert "Both angles are singular" in told(taught, **at)
    before = taught.quantities
    taught.alter(nudge=DEGREE)
    after = taught.quantities
    assert np.degrees(np.arccos(before.n @ after.n)) > 4.9
    assert abs(np.degrees(after.dtheta_c - before.dtheta_c)) > 4.9


@pytest.mark.parametrize(
    ("change", "kept"),
    [({"swing": 2.0}, ("theta_p", "v", "dtheta_c")), ({"bend": 1.0}, ("q", "dtheta_c"))],
)
def test_what_stays_stays(taught, change, kept):
    still = taught.quantities
    text = told(taught, **change)
    assert "change" in text
    for name in kept:
        assert getattr(taught.quantities, name) == pytest.approx(getattr(still, name), abs=1e-7)
    if "bend" in change:
        was, now = (d.across / np.linalg.norm(d.across) for d in (still, taught.quantities))
        assert now == pytest.approx(was, abs=1e-7)


def test_the_stages_are_told_with_the_angles_reached(taught):
    whole = taught.quantities
    taught.set_stage(0.5)
    share, alpha = numbers_in(told(taught))
    assert share == 50.0
    assert alpha == pytest.approx(np.degrees(0.5 * whole.alpha), abs=0.51)
    taught.set_stage(1.25)
    share, theta = numbers_in(told(taught))
    assert share == 25.0
    assert theta == pytest.approx(np.degrees(0.25 * whole.theta_p), abs=0.06)
    assert taught.quantities.w == pytest.approx(whole.w, abs=1e-9)


@pytest.mark.thorough
def test_all_words_fit_in_two_lines(qtbot, at_forearm):
    act(at_forearm, "show_teaching")
    box, frame = at_forearm.teaching.what_if, at_forearm.taught
    width = 480  # pixels, of the tab in a window 1280 wide
    edge = frame.document.intervals[0].interval
    seen = set()
    for chain, at in (("LeftArm", 90), ("LeftForeArm", 90), (edge.chain, edge.start)):
        frame.document.select_chain(chain)
        frame.document.go_to(at)
        own = [j.id for j in frame.document.intervals if j.interval.chain == chain]
        for chosen in (None, *own[:1]):
            frame.document.select_interval(chosen)
            for twist in (0.0, -0.5, 0.5, PI):
                for rest in (
                    WhatIf(), WhatIf(counter=True), WhatIf(swing=PI), WhatIf(swing=3.06),
                    WhatIf(bend=0.0), WhatIf(bend=0.05), WhatIf(bend=3.1), WhatIf(nudge=0.01),
                    WhatIf(swing=PI, bend=0.0), WhatIf(applied=1.0), WhatIf(swing=1.0),
                    WhatIf(bend=1.0), WhatIf(applied=0.55, counter=True),
                ):  # fmt: skip
                    what_if = replace(rest, twist=twist)
                    frame.set_what_if(what_if)
                    for stage in (None, 0.4, 1.6):
                        frame.set_stage(stage)
                        text, role = what_if_comment(frame.numbers, what_if, stage)
                        assert hasattr(DARK, role)
                        box.words.setText(text)
                        assert box.words.heightForWidth(width) <= box.words.minimumHeight() + 2, (
                            text
                        )
                        seen.add(text[:12])
    assert len(seen) >= 12


def test_the_frame_before_may_be_what_is_undefined(taught):
    data = taught.document.data
    d = decompose(data.motion, taught.chain, 90)
    gone = taught.numbers._replace(frame=replace(d, swing_reliability_before=0.0))
    assert "previous frame" in what_if_comment(gone, WhatIf())[0]
    gone = taught.numbers._replace(frame=replace(d, across_before=np.zeros(3)))
    assert "previous frame" in what_if_comment(gone, WhatIf())[0]
