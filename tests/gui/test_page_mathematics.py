"""The mathematics of a lesson's page, in JavaScript, gives the numbers of twistcore."""

import itertools
import json
from dataclasses import asdict, fields

import numpy as np
import pytest
from PySide6.QtQml import QJSEngine

from inspector.bundled import ASSETS
from inspector.teaching.symbols import SECTIONS
from inspector.viewport.bodies import find_bones
from inspector.viewport.striped_skin import STATIONS, build_skin, drape
from twistcore.bvh import read_bvh
from twistcore.chain import find_chains
from twistcore.decomposition import Decomposition, WhatIf, altered, decompose
from twistcore.detection.paper import error_of
from twistcore.motion import forward_kinematics

SCRIPT = (ASSETS / "lesson_page" / "swing_twist.js").read_text("utf-8")
EXACT = 1e-9
NEAR = 1e-3  # radians: where a swing is 180° or a limb straight, an angle is any angle

COMPARE = """
function compare(text) {
  const c = JSON.parse(text);
  const out = SwingTwist.altered(c.rotations, c.chain, c.whatIf, c.offset, c.stage);
  const q = [c.chain.parent, c.chain.child];
  const d = SwingTwist.decompose(
    { q: out[q[0]], qChild: out[q[1]], axis: c.chain.axis, arm: c.chain.arm },
    { q: c.before[q[0]], qChild: c.before[q[1]], axis: c.chain.axis, arm: c.chain.arm });
  const world = SwingTwist.forwardKinematics(c.parents, out, c.translations);
  return JSON.stringify({ d: d, world: world, error: SwingTwist.errorOf(d, c.tau) });
}
"""


@pytest.fixture(scope="module")
def engine(qapp):
    engine = QJSEngine()
    for script in (SCRIPT, COMPARE):
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


def test_two_hundred_frames_and_what_ifs(engine):
    for motion, chain, frame, what_if, offset, stage in cases():
        tau = 0.05
        told = {
            "rotations": motion.rotations[frame].tolist(),
            "before": motion.rotations[frame - 1].tolist(),
            "translations": translations(motion, frame),
            "parents": motion.skeleton.parents.tolist(),
            "chain": {
                "parent": chain.parent,
                "child": chain.child,
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
        theirs = called(engine, "compare", json.dumps(told))
        mine = decompose(motion, chain, frame, what_if, offset=offset, stage=stage)
        for field in fields(Decomposition):
            difference = np.subtract(theirs["d"][field.name], getattr(mine, field.name))
            if field.name in ("theta_p", "dtheta_p", "dtheta_c", "theta_p_before"):
                difference = np.angle(np.exp(1j * difference))
            assert np.abs(difference).max() <= EXACT, (field.name, chain.name, what_if)
        assert theirs["error"] == pytest.approx(
            float(error_of(mine.dtheta_p, mine.strength, tau)), abs=EXACT
        )
        one = altered(motion, chain, frame, what_if, offset=offset, stage=stage)
        rotations, positions = forward_kinematics(one)
        assert np.abs(theirs["world"]["rotations"] - rotations[0]).max() <= EXACT
        scale = motion.skeleton.height
        assert np.abs(theirs["world"]["positions"] - positions[0]).max() <= EXACT * scale


def translations(motion, frame):
    places = [motion.translation(j) for j in range(len(motion.skeleton))]
    return [(p if p.ndim == 1 else p[frame]).tolist() for p in places]


def test_rows_say_what_the_program_says(engine):
    result = engine.evaluate(
        (ASSETS / "lesson_page" / "labels.js").read_text("utf-8")
        + "function said(text) { const d = JSON.parse(text), out = {};"
        "Object.keys(Labels.ROWS).forEach((name) => { out[name] = Labels.ROWS[name](d); });"
        "return JSON.stringify(out); }"
    )
    assert not result.isError(), result.toString()
    equations = list(itertools.chain(*SECTIONS.values()))
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion
    for own in find_chains(motion):
        for frame in range(0, motion.frames, 23):
            d = decompose(motion, own, frame)
            told = {f.name: np.asarray(getattr(d, f.name)).tolist() for f in fields(d)}
            rows = called(engine, "said", json.dumps(told | {"product": d.product}))
            assert rows == {e.symbol: e.value(d) for e in equations}


def test_the_skin_is_draped_as_in_the_program(engine):
    result = engine.evaluate(
        (ASSETS / "lesson_page" / "striped_skin.js").read_text("utf-8")
        + "function draped(text) { const c = JSON.parse(text), points = [], normals = [];"
        "StripedSkin.drape(c.skin, c.pose, points, normals, 1.09);"
        "return JSON.stringify({ points: points, normals: normals }); }"
    )
    assert not result.isError(), result.toString()
    motion = read_bvh(ASSETS / "walk_injected.bvh").motion
    bones = find_bones(motion, np.array([0.0, 1.0, 0.0]), motion.skeleton.height)
    skin = build_skin(bones, find_chains(motion), motion.skeleton.height)
    names = ("parent", "child", "below", "above", "axis", "across", "radius", "circle")
    told = {name: getattr(skin, name).tolist() for name in names} | {"stations": STATIONS.tolist()}
    rotations, positions = forward_kinematics(motion)
    for frame in (0, 66, 90):
        pose = {"rotations": rotations[frame].tolist(), "positions": positions[frame].tolist()}
        theirs = called(engine, "draped", json.dumps({"skin": told, "pose": pose}))
        mine = drape(skin, rotations[frame], positions[frame], grown=1.09)
        for name, vectors in zip(("points", "normals"), mine, strict=True):
            assert np.reshape(theirs[name], (-1, 3)) == pytest.approx(vectors, abs=1e-9 * 180.0)
