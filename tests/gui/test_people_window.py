"""Two people in a clip: the list of people, their chains and intervals, and the camera."""

import numpy as np
import pytest

from inspector.session.settings import Settings
from tests.gui.windows import act, open_clip
from tests.twistcore.two_people import two_people
from twistcore.skeleton.rig import Rig

ONE_WINDOW = True
APART = 60.0  # length units between the two


@pytest.fixture
def pair(qtbot, window_for_clips, tmp_path):
    """The walk and the walk with errors next to it, in a window."""
    clip = tmp_path / "pair.bvh"
    clip.write_bytes(two_people(apart=APART, backwards=True))
    window = window_for_clips(Settings())
    open_clip(qtbot, window, clip)
    return window


def choose(window, person):
    box = window.chains.people
    at = box.findData(person)
    box.setCurrentIndex(at)
    box.activated.emit(at)


def rows(window):
    model = window.chains.table.model()
    return [model.index(k, 0).data() for k in range(model.rowCount())]


def seen(window, person):
    """Whether a person is in the picture, how much of its height they take, and how far aside."""
    view = window.viewport
    width, height = view.picture_size()
    joints = list(view.scene.people[person])
    pixels, _ = view.camera.project(
        window.document.data.positions[window.document.frame, joints], width, height
    )
    inside = (pixels >= 0.0) & (pixels <= (width, height))
    aside = abs(pixels[:, 0].mean() / width - 0.5)
    return bool(inside.all()), float(np.ptp(pixels[:, 1]) / height), float(aside)


def test_the_chains_and_intervals_of_one_person_are_listed(pair):
    every = rows(pair)
    assert {label[0] for label in every} == {"A", "B"}
    choose(pair, "B")
    assert rows(pair) == [label for label in every if label.startswith("B ·")]
    assert pair.intervals.shown_ids()
    choose(pair, "A")
    assert rows(pair) == [label for label in every if label.startswith("A ·")]
    assert pair.intervals.shown_ids() == ()
    assert pair.document.find_chain(pair.document.chain).person == "A"
    choose(pair, "")
    assert rows(pair) == every
    assert len(pair.intervals.shown_ids()) == len(pair.document.intervals)


@pytest.mark.thorough
def test_a_person_who_is_chosen_is_at_a_chain_with_intervals(pair):
    choose(pair, "A")
    choose(pair, "B")
    assert pair.document.chain in {j.interval.chain for j in pair.document.intervals}


@pytest.mark.thorough
def test_the_camera_shows_everyone_and_then_the_one_who_is_chosen(pair):
    assert seen(pair, "A")[0]
    assert seen(pair, "B")[0]
    _, both, aside = seen(pair, "B")
    assert aside > 0.1
    choose(pair, "B")
    inside, size, aside = seen(pair, "B")
    assert inside
    assert size > 1.3 * both
    assert aside < 0.1
    choose(pair, "")
    assert seen(pair, "A")[0]
    assert seen(pair, "B")[0]


@pytest.mark.thorough
def test_the_camera_goes_along_with_the_one_who_is_chosen(pair):
    choose(pair, "B")
    root = pair.viewport.scene.people["B"][0]
    places = pair.document.data.positions[:, root]
    before = pair.viewport.camera.target
    pair.document.go_to(200)
    pair.viewport.refresh()
    moved = pair.viewport.camera.target - before
    way = places[200] - places[0]
    np.testing.assert_allclose(moved[[0, 2]], way[[0, 2]], atol=1e-6)


@pytest.mark.thorough
def test_a_limb_is_looked_at_from_its_own_person_s_side(pair):
    """The same pose is seen from the same direction, whoever stands next to it."""
    view, document = pair.viewport, pair.document
    directions = []
    for name, frame in (("LeftLeg", 100), ("LeftLeg_B", document.frames - 101)):
        document.go_to(frame)
        document.select_chain(name)
        view.focus_chain()
        directions.append(view.camera.direction)
    assert directions[0] @ directions[1] > np.cos(np.radians(10.0))


@pytest.mark.thorough
def test_who_is_chosen_stays_when_chains_change_and_ends_with_the_clip(qtbot, pair, tmp_path):
    with qtbot.waitSignal(pair.document.chains_changed, timeout=60_000):
        pair.document.change_chains(Rig(remove=("LeftArm",)), "Remove a chain")
    choose(pair, "B")
    listed = rows(pair)
    with qtbot.waitSignal(pair.document.chains_changed, timeout=60_000):
        act(pair, "undo")
    assert pair.chains.people.currentData() == "B"
    assert rows(pair) == listed
    assert "LeftArm" in pair.document.hidden
    other = tmp_path / "other.bvh"
    other.write_bytes(two_people("B:*"))
    open_clip(qtbot, pair, other)
    assert pair.document.person == ""
    assert pair.chains.people.currentData() == ""
    assert {label[0] for label in rows(pair)} == {"A", "B"}
