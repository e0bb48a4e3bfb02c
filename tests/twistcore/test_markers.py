"""The script for Blender: valid Python that sets the markers."""

import sys
from types import SimpleNamespace

import numpy as np

from tests.twistcore.reviews import flip
from twistcore.detection import Interval
from twistcore.export.markers import blender_markers
from twistcore.review import Decision, Judged


def test_the_script_sets_two_markers_an_interval(monkeypatch):
    judged = [
        Judged(
            1,
            Interval('Left "Arm" \\', 10, 20, np.full(10, 0.5)),
            Decision.ACCEPTED,
            reviewer="Ada",
        ),
        Judged(2, Interval("LeftLeg", 30, 31, np.full(1, -0.5)), Decision.REJECTED),
        Judged(3, flip(start=40, stop=44)),
    ]
    script = blender_markers('a """clip""".bvh', judged)
    markers = []
    scene = SimpleNamespace(
        frame_start=1,
        timeline_markers=SimpleNamespace(new=lambda name, frame: markers.append((name, frame))),
    )
    bpy = SimpleNamespace(context=SimpleNamespace(scene=scene))
    monkeypatch.setitem(sys.modules, "bpy", bpy)
    exec(compile(script, "markers.py", "exec"), {})
    name = 'Left "Arm" \\ +28.6° accepted'
    assert markers[:2] == [(f"{name} [", 11), (f"] {name}", 20)]
    assert markers[2] == ("RightUpLeg-RightFoot limb flip +170.0° undecided [", 41)
