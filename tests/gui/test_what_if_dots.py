"""A what-if is a dot in the plots, at the values that the clip would have with it."""

import numpy as np
import pytest

from inspector.recording.choice import RecordChoice, Shot
from inspector.recording.stage import Shown, Stage
from inspector.widgets.axes import root_scale_to_degrees
from inspector.widgets.theme import DARK
from twistcore.analysis.decomposition import WhatIf, frame_motion_with_user_changes
from twistcore.skeleton.rotation import wrap
from twistcore.skeleton.signals import twist_signals

ONE_WINDOW = True
FRAME = 90


@pytest.fixture
def taught(taught):
    taught.document.select_chain("LeftArm")
    taught.document.go_to(FRAME)
    taught.timeline.refresh()
    return taught


def dots(timeline):
    """(frame, degrees, ring) of every dot, by plot."""
    out = {}
    for key, layer in timeline.dots.layers.items():
        root = timeline.panes[key].root
        out[key] = [
            (layer.frame, float(root_scale_to_degrees(y)) if root else y, ring)
            for y, ring in layer.dots
        ]
    return out


def would_be(window, frame):
    """Signals of the clip with the frame altered, computed over the whole clip."""
    motion, chain = window.document.data.motion, window.taught.chain
    one = frame_motion_with_user_changes(motion, chain, frame, window.taught.what_if)
    rotations = motion.rotations.copy()
    rotations[frame] = one.rotations[0]
    return twist_signals(motion.with_rotations(rotations), chain)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "what_if",
    [
        WhatIf(twist=1.1),
        WhatIf(twist=2.5, counter=True),
        WhatIf(swing=2.0, bend=1.2, twist=-1.0, counter=True),
        WhatIf(toward=(0.0, 0.6, 0.8)),
    ],
)
@pytest.mark.parametrize("chain", ["LeftArm", "RightUpLeg"])
def test_a_dot_is_where_the_curve_would_be(taught, what_if, chain):
    taught.document.select_chain(chain)
    taught.timeline.refresh()
    taught.taught.set_what_if(what_if)
    signals = would_be(taught, FRAME)
    seen = dots(taught.timeline)
    (_, p, p_ring), (_, c, c_ring) = seen["theta"]
    assert (p_ring, c_ring) == (False, True)
    assert wrap(np.radians(p) - signals.theta_p[FRAME]) == pytest.approx(0.0, abs=1e-6)
    assert wrap(np.radians(c) - signals.theta_c[FRAME]) == pytest.approx(0.0, abs=1e-6)
    (_, dp, _), (_, dc, _) = seen["delta"]
    assert dp == pytest.approx(np.degrees(signals.dtheta_p[FRAME]), abs=1e-6)
    assert dc == pytest.approx(np.degrees(signals.dtheta_c[FRAME]), abs=1e-6)
    ((frame, m, _),) = seen["strength"]
    assert m == pytest.approx(np.degrees(signals.strength[FRAME]), abs=1e-6)
    assert frame == FRAME


@pytest.mark.thorough
def test_dots_go_with_the_playhead_and_the_title_tells_their_numbers(taught):
    taught.taught.set_what_if(WhatIf(twist=1.1, counter=True))
    taught.document.go_to(120)
    assert {d[0] for each in dots(taught.timeline).values() for d in each} == {120}
    words = "".join(text for text, _ in taught.timeline.panes["strength"].front.title)
    m = np.degrees(taught.taught.quantities.strength)
    assert f"what if m ● {m:.1f}°" in words


@pytest.mark.thorough
def test_what_is_undefined_has_no_dot(taught):
    taught.taught.set_what_if(WhatIf(swing=np.pi))
    seen = dots(taught.timeline)
    assert [ring for *_, ring in seen["theta"]] == [True]
    assert [ring for *_, ring in seen["delta"]] == [True]
    assert seen["strength"] == []
    taught.taught.set_what_if(WhatIf(bend=0.0))
    seen = dots(taught.timeline)
    assert [ring for *_, ring in seen["theta"]] == [False]
    assert [ring for *_, ring in seen["delta"]] == [False]
    assert seen["strength"] == []


@pytest.mark.thorough
def test_without_a_what_if_or_the_tab_there_is_none(qtbot, taught):
    assert not any(dots(taught.timeline).values())
    taught.taught.set_what_if(WhatIf(twist=1.1))
    assert all(dots(taught.timeline).values())
    taught.taught.set_stage(0.5)  # on its way nothing is compared
    assert not any(dots(taught.timeline).values())
    taught.taught.set_stage(None)
    assert all(dots(taught.timeline).values())
    taught.docks["intervals"].raise_()
    qtbot.waitUntil(lambda: not taught.taught.active)
    assert not any(dots(taught.timeline).values())


@pytest.mark.thorough
def test_a_dot_outside_is_brought_into_view_and_the_range_comes_back(taught):
    pane = taught.timeline.panes["strength"]
    before = pane.time.viewRange()[1]
    taught.taught.set_what_if(WhatIf(twist=2.5, counter=True))
    ((height, _),) = taught.timeline.dots.layers["strength"].dots
    low, high = pane.time.viewRange()[1]
    assert before[1] < height < high
    assert low == before[0]
    taught.taught.set_what_if(WhatIf(twist=0.5, counter=True))
    assert pane.time.viewRange()[1] == [low, high]  # it does not move under the hand
    taught.taught.reset()
    assert pane.time.viewRange()[1] == pytest.approx(before)


@pytest.mark.thorough
def test_a_range_chosen_by_a_person_stays(taught):
    pane = taught.timeline.panes["theta"]
    pane.time.zoom_values(10.0, 4.0)
    chosen = pane.time.viewRange()[1]
    taught.taught.set_what_if(WhatIf(twist=2.5, counter=True))
    assert pane.time.viewRange()[1] == chosen
    taught.taught.reset()
    assert pane.time.viewRange()[1] == chosen


@pytest.mark.thorough
def test_dots_are_seen(qtbot, taught):
    def blue():
        qtbot.wait(60)
        image = taught.timeline.panes["strength"].grab().toImage()
        wanted = taught.timeline.scenery.theme.after
        return sum(
            image.pixelColor(x, y).name() == wanted
            for x in range(image.width())
            for y in range(20, image.height())
        )

    assert taught.timeline.scenery.theme == DARK
    before = blue()
    taught.taught.set_what_if(WhatIf(twist=1.1, counter=True))
    assert blue() > before + 25


@pytest.mark.thorough
def test_a_recording_has_them_too(taught, tmp_path):
    taught.taught.set_what_if(WhatIf(twist=1.1, counter=True))
    taught.taught.set_stage(2.0)
    wanted = dots(taught.timeline)
    views = taught.viewport, taught.timeline, taught.teaching.typesetter
    size = taught.width(), taught.height()
    stage = Stage(Shown(taught.taught, *views), RecordChoice(tmp_path / "a.mp4", size=size))
    stage.show_shot(Shot(FRAME))
    assert dots(stage.timeline) == wanted
    assert stage.viewport.drawing.guest.legend() == taught.teaching.gizmo.legend()
    stage.close_views()
