"""The mathematics of a lesson's page, in JavaScript, gives the numbers of twistcore."""

import json
from dataclasses import asdict, fields

import numpy as np
import pytest
from PySide6.QtQml import QJSEngine

from inspector.bundled import ASSETS
from inspector.session.opening import analyse_clip
from inspector.teaching.equation_table import SECTIONS
from inspector.teaching.gizmo_family import MEMBERS, add_swing_axis_fan
from inspector.teaching.gizmo_joints import triads
from inspector.teaching.gizmo_shapes import Sketch
from inspector.teaching.taught_frame import FrameNumbers
from inspector.teaching.what_if_words import what_if_comment
from inspector.viewport.bodies import find_bones
from inspector.viewport.striped_skin import STATIONS, build_skin, pose_skin
from twistcore.analysis.decomposition import (
    Decomposition,
    WhatIf,
    decompose,
    detect_and_correct_frame,
    frame_motion_with_user_changes,
)
from twistcore.detection.paper import paper_detector_running_offset
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.chain import find_chains
from twistcore.skeleton.motion import forward_kinematics

SCRIPTS = ("language.js", "swing_twist.js", "labels.js", "words.js", "striped_skin.js", "gizmo.js")
EXACT = 1e-9
NEAR = 1e-3  # radians: where a swing is 180° or a limb straight, an angle is any angle

COMPARE = """
function compare(text) {
  const c = JSON.parse(text);
  const of = SwingTwist.numbersOf(
    { rotations: c.rotations, chain: c.chain }, { rotations: c.before, chain: c.chain },
    c.whatIf, c.stage, c.tau, c.offset);
  const world = SwingTwist.forwardKinematics(c.parents, of.rotations, c.translations);
  const rows = {};
  Labels.NAMES.forEach((name) => { rows[name] = Labels.row(name, of); });
  return JSON.stringify(
    { of: of, world: world, rows: rows, said: Words.say(of, c.whatIf, c.stage) });
}
"""

DRAWN = """
function drawn(text) {
  const c = JSON.parse(text), at = { rotations: c.rotations, chain: c.chain };
  const of = SwingTwist.numbersOf(
    at, { rotations: c.before, chain: c.chain }, c.whatIf, c.stage, c.tau, c.offset);
  const pose = SwingTwist.forwardKinematics(c.parents, of.rotations, c.translations);
  const { parent, child } = c.chain;
  const out = Gizmo.sketch(of.frame, pose.rotations[parent], pose.positions[parent],
    pose.positions[child], 1, 1e-3, c.stage !== null);
  Gizmo.drawTriads(out, c.chain, pose);
  return JSON.stringify(out);
}
"""


@pytest.fixture(scope="module")
def engine(qapp):
    engine = QJSEngine()
    own = [(ASSETS / "lesson_page" / name).read_text("utf-8") for name in SCRIPTS]
    for script in (*own, COMPARE, DRAWN):
        result = engine.evaluate(script)
        assert not result.isError(), result.toString()
    return engine


def called(engine, name, *arguments):
    value = engine.globalObject().property(name).call([*arguments])
    assert not value.isError(), value.toString()
    return json.loads(value.toString())


def any_what_if(rng):
    """Each part of a what-if in about half of the cases, close by the singular ends, too."""

    def perhaps(value):
        return value if rng.random() < 0.5 else None

    return WhatIf(
        twist=perhaps(float(rng.uniform(-np.pi, np.pi))) or 0.0,
        counter=bool(rng.random() < 0.5),
        swing=perhaps(float(rng.choice([NEAR, np.pi - NEAR, rng.uniform(NEAR, np.pi - NEAR)]))),
        bend=perhaps(float(rng.choice([NEAR, np.pi - NEAR, rng.uniform(NEAR, np.pi - NEAR)]))),
        nudge=perhaps(float(np.radians(rng.uniform(-3.0, 3.0)))) or 0.0,
        toward=perhaps(tuple(rng.normal(size=3).tolist())),
        applied=perhaps(float(rng.uniform(0.0, 1.0))) or 0.0,
    )


def cases():
    rng = np.random.default_rng(5)
    clips = [read_bvh(ASSETS / name).motion for name in ("walk_injected.bvh", "dance.bvh")]
    for k in range(200):
        motion = clips[k % 2]
        chains = find_chains(motion)
        chain = chains[rng.integers(len(chains))]
        stage = float(rng.uniform(0.0, 2.0)) if rng.random() < 0.3 else None
        frame, offset = int(rng.integers(1, motion.frames)), float(rng.uniform(-4.0, 4.0))
        yield motion, chain, frame, any_what_if(rng), offset, stage


def told(motion, chain, frame, what_if, offset, stage, tau):
    """A frame as the page knows it."""
    return {
        "rotations": motion.rotations[frame].tolist(),
        "before": motion.rotations[max(frame - 1, 0)].tolist(),
        "translations": translations(motion, frame),
        "parents": motion.skeleton.parents.tolist(),
        "chain": {
            "parent": chain.parent,
            "child": chain.child,
            "grandchild": chain.grandchild,
            "children": list(motion.skeleton.children[chain.parent]),
            "axis": chain.axis.tolist(),
            "arm": chain.arm.tolist(),
            "free": True,
        },
        "whatIf": asdict(what_if),
        "offset": offset,
        "stage": stage,
        "tau": tau,
    }


def numbers_of(motion, chain, frame, what_if, offset, stage, tau):
    """The same frame as the teaching tab knows it."""
    found = detect_and_correct_frame(motion, chain, frame, what_if, tau=tau, offset_before=offset)
    shown = decompose(motion, chain, frame, what_if, offset=found.whole, stage=stage)
    return FrameNumbers(shown, found, staged=stage is not None)


def same(theirs, mine, what):
    """Every number of two records is equal."""
    for field in fields(mine):
        value = getattr(mine, field.name)
        if isinstance(value, Decomposition):
            same(theirs[field.name], value, what)
        elif field.name not in ("q_parent", "q_child"):  # these the page does not keep
            difference = np.subtract(theirs[field.name], value)
            if np.ndim(value) == 0:
                difference = np.angle(np.exp(1j * difference))
            assert np.abs(difference).max() <= EXACT, (field.name, what)


@pytest.mark.thorough
def test_two_hundred_frames_and_what_ifs(engine):
    tau = 0.05
    for motion, chain, frame, what_if, offset, stage in cases():
        case = (motion, chain, frame, what_if, offset, stage, tau)
        theirs, mine = called(engine, "compare", json.dumps(told(*case))), numbers_of(*case)
        same(theirs["of"]["frame"], mine.frame, (chain.name, what_if))
        same(theirs["of"]["correction"], mine.correction, (chain.name, what_if))
        for name in ("swing_is_one", "n_is_defined", "strength_is_defined"):
            assert theirs["of"]["frame"][name] == getattr(mine.frame, name)
        off = mine.correction.whole
        one = frame_motion_with_user_changes(motion, chain, frame, what_if, offset=off, stage=stage)
        rotations, positions = forward_kinematics(one)
        assert np.abs(theirs["world"]["rotations"] - rotations[0]).max() <= EXACT
        scale = motion.skeleton.height
        assert np.abs(theirs["world"]["positions"] - positions[0]).max() <= EXACT * scale


def translations(motion, frame):
    places = [motion.translation(j) for j in range(len(motion.skeleton))]
    return [(p if p.ndim == 1 else p[frame]).tolist() for p in places]


WHAT_IFS = (
    *(WhatIf(), WhatIf(counter=True), WhatIf(swing=2.0), WhatIf(bend=0.7), WhatIf(nudge=0.02)),
    *(WhatIf(twist=1.0), WhatIf(twist=1.0, counter=True), WhatIf(twist=3.1, counter=True)),
    *(WhatIf(twist=1.0, counter=True, applied=0.5), WhatIf(twist=1.0, swing=1.0)),
    *(WhatIf(swing=np.pi - NEAR), WhatIf(bend=NEAR), WhatIf(swing=np.pi - NEAR, bend=NEAR)),
    *(WhatIf(swing=np.pi), WhatIf(bend=0.0), WhatIf(bend=np.pi - NEAR), WhatIf(applied=1.0)),
)


@pytest.mark.thorough
def test_rows_and_words_say_what_the_program_says(engine):
    clip = analyse_clip(read_bvh(ASSETS / "walk_injected.bvh"))
    motion, said = clip.motion, set()
    rows = [equation for section in SECTIONS for equation in section.rows]
    for chain in clip.chains:
        tau = clip.review.state.tau[chain.name]
        running = paper_detector_running_offset(clip.signals[chain.name], tau)
        for k, frame in enumerate(range(0, motion.frames, 19)):
            for stage in (None, 0.6, 1.4) if k == 0 else (None,):
                what_if = WHAT_IFS[k % len(WHAT_IFS)] if stage is None else WhatIf()
                before = float(running[frame - 1]) if frame else 0.0
                case = (motion, chain, frame, what_if, before, stage, tau)
                theirs, mine = called(engine, "compare", json.dumps(told(*case))), numbers_of(*case)
                assert theirs["said"] == dict(
                    zip(("text", "role"), what_if_comment(mine, what_if, stage), strict=True)
                )
                said.add(theirs["said"]["text"].split(" ")[0])
                for row in rows:
                    text, ours = theirs["rows"][row.symbol], row.value(mine)
                    if (
                        ours.startswith("no")
                        and abs(np.degrees(np.degrees(mine.frame.product))) < 1e-9
                    ):
                        text, ours = text[:2], ours[:2]  # whose rounding is below zero differs
                    assert text == ours, (row.symbol, what_if)
    assert len(said) > 8


def test_the_skin_is_draped_as_in_the_program(engine):
    result = engine.evaluate(
        "function draped(text) { const c = JSON.parse(text), points = [], normals = [];"
        "StripedSkin.drape(c.skin, c.pose, points, normals, 1.09);"
        "return JSON.stringify({ points: points, normals: normals }); }"
    )
    assert not result.isError(), result.toString()
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion
    bones = find_bones(motion, np.array([0.0, 1.0, 0.0]), motion.skeleton.height)
    skin = build_skin(bones, find_chains(motion), motion.skeleton.height)
    names = (
        *("parent", "child", "below", "above", "axis", "across", "radius", "circle"),
        *("fin", "fin_normals"),
    )
    as_json = {name: getattr(skin, name).tolist() for name in names} | {
        "stations": STATIONS.tolist()
    }
    rotations, positions = forward_kinematics(motion)
    for frame in (0, 66, 90):
        pose = {"rotations": rotations[frame].tolist(), "positions": positions[frame].tolist()}
        theirs = called(engine, "draped", json.dumps({"skin": as_json, "pose": pose}))
        mine = pose_skin(skin, rotations[frame], positions[frame], grown=1.09)
        for name, vectors in zip(("points", "normals"), mine, strict=True):
            assert np.reshape(theirs[name], (-1, 3)) == pytest.approx(vectors, abs=1e-9 * 180.0)


TURNED = WhatIf(swing=np.radians(179.0))


@pytest.mark.parametrize("what_if", [WhatIf(), TURNED, WhatIf(swing=np.pi), WhatIf(twist=1.0)])
def test_the_family_and_the_axes_of_joints_are_drawn_as_in_the_program(engine, what_if):
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion
    chain = next(c for c in find_chains(motion) if c.name == "LeftArm")
    case = (motion, chain, 200, what_if, 0.0, None, 0.05)
    theirs = called(engine, "drawn", json.dumps(told(*case)))
    d = numbers_of(*case).frame
    rotations, positions = forward_kinematics(
        frame_motion_with_user_changes(motion, chain, 200, what_if)
    )
    rotations, positions = rotations[0], positions[0]
    parent, scale = positions[chain.parent], motion.skeleton.height
    unit = float(np.linalg.norm(positions[chain.child] - parent))
    mine = Sketch(unit)
    add_swing_axis_fan(mine, d, rotations[chain.parent], parent)
    spokes, _, hands = (part.points.reshape(MEMBERS, -1, 3) for part in mine.parts[:3])
    near = what_if.swing is not None
    seen = [p for p in theirs["parts"] if p["kind"] == "line" and not p.get("colour")]
    own = [p["points"] for p in seen if p["symbol"] == "n" and p["share"] == 0.8]
    shown = [p["points"] for p in seen if p["symbol"] == "theta_p" and p["width"] == 3]
    assert len(own) == MEMBERS * near
    if near:
        assert np.abs(own - spokes).max() <= EXACT * scale
        assert np.abs(shown[:MEMBERS] - hands).max() <= EXACT * scale
        words = [mark["words"] for mark in theirs["marks"] if mark.get("words")]
        assert words == [mark.words for mark in mine.marks]
    axes = [p["points"] for p in theirs["parts"] if p.get("colour")]
    lines = triads(chain, rotations, positions, unit).reshape(-1, 2, 3)
    assert np.abs(axes - lines).max() <= EXACT * scale


def test_the_page_draws_no_angle_that_is_undefined_or_on_its_way(engine):
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion
    chain = next(c for c in find_chains(motion) if c.name == "LeftArm")

    def marks(what_if, stage=None):
        case = (motion, chain, 200, what_if, 0.0, stage, 0.05)
        out = called(engine, "drawn", json.dumps(told(*case)))
        return {mark["symbol"] for mark in out["marks"] if not mark.get("words")}

    changed = {"dtheta_p", "dtheta_c"}
    assert changed <= marks(WhatIf(twist=1.0, counter=True))
    assert not changed & marks(WhatIf(twist=1.0, counter=True), stage=1.5)
    assert "dtheta_c" not in marks(WhatIf(bend=0.0))
    assert not {"n", "theta_p", "dtheta_p"} & marks(WhatIf(swing=np.pi))
