"""Scene files of other programs are opened as the clip that Blender makes of them."""

import json
import stat
import sys

import numpy as np
import pytest

from tests.tiers import parametrize
from tests.twistcore.test_convert import MOTION, NAMES, PARENTS, handover
from twistcore.formats.bvh import read_bvh
from twistcore.skeleton.rotation import geodesic_angle


@pytest.fixture
def blender(tmp_path, monkeypatch):
    """A program that hands over the walk as Blender would."""
    scene, folder = handover(MOTION), tmp_path / "program"
    folder.mkdir()
    np.savez(folder / "arrays.npz", rest=scene.rest, tails=scene.tails, poses=scene.poses)
    answer = {
        "names": NAMES, "parents": PARENTS.tolist(), "fps": MOTION.fps, "figure": "walk",
        "take": "", "blender": "5.0.1",
    }  # fmt: skip
    program = folder / "blender"
    program.write_text(
        f"#!{sys.executable}\nimport json, sys\nfrom pathlib import Path\n"
        "out = Path(json.loads(Path(sys.argv[-1]).read_text())['out'])\n"
        f"(out / 'arrays.npz').write_bytes(Path({str(folder / 'arrays.npz')!r}).read_bytes())\n"
        f"(out / 'answer.json').write_text({json.dumps(answer)!r})\n"
    )
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("TWIST_BLENDER", str(program))
    return program


@parametrize("name", ["walk.fbx", "Walk.GLB", "walk.blend"])
def test_a_scene_is_opened_as_the_clip_that_blender_makes_of_it(
    qtbot, window, tmp_path, blender, name
):
    scene = tmp_path / name
    scene.write_bytes(b"scene")
    window.open_path(scene)
    qtbot.waitUntil(lambda: window.document.data is not None, timeout=60_000)
    clip = scene.with_suffix(".bvh")
    assert window.document.data.clip.path == clip
    written = read_bvh(clip).motion
    assert np.degrees(geodesic_angle(written.rotations, MOTION.rotations)).max() < 1e-3
    assert scene.read_bytes() == b"scene"


def test_an_earlier_conversion_is_never_replaced(qtbot, window, tmp_path, blender):
    scene, clip = tmp_path / "walk.fbx", tmp_path / "walk.bvh"
    scene.write_bytes(b"scene")
    window.open_path(scene)
    qtbot.waitUntil(lambda: window.document.data is not None, timeout=60_000)
    before = clip.read_bytes(), clip.stat().st_mtime_ns
    blender.unlink()  # not asked again
    window.open_path(scene)
    qtbot.waitUntil(lambda: clip.name in window.bar.label.text(), timeout=60_000)
    assert not window.bar.property("wrong")
    assert (clip.read_bytes(), clip.stat().st_mtime_ns) == before


def test_without_blender_one_sentence_names_the_way_to_get_it(qtbot, window, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("TWIST_BLENDER", raising=False)
    monkeypatch.setattr("twistcore.formats.blender.process.find_spec", lambda _: None)
    scene = tmp_path / "walk.fbx"
    scene.write_bytes(b"scene")
    window.open_path(scene)
    qtbot.waitUntil(lambda: bool(window.bar.property("wrong")), timeout=60_000)
    assert "TWIST_BLENDER" in window.bar.label.text()
    assert [path.name for path in tmp_path.glob("walk*")] == ["walk.fbx"]


def test_a_blender_that_fails_leaves_nothing(qtbot, window, tmp_path, blender):
    blender.write_text(f"#!{sys.executable}\nimport sys\nsys.exit(11)\n")
    scene = tmp_path / "walk.fbx"
    scene.write_bytes(b"scene")
    window.open_path(scene)
    qtbot.waitUntil(lambda: bool(window.bar.property("wrong")), timeout=60_000)
    assert window.document.data is None
    assert [path.name for path in tmp_path.glob("walk*")] == ["walk.fbx"]
