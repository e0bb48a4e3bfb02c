"""What a manifest has in its rows: whatever stands there, what is taken from it can be told."""

import json

import pytest

import twistcore as tc
from tests.conftest import ASSETS
from tests.twistcore.reviews import spun
from twistcore.batch.clip_task import run_task
from twistcore.batch.inputs import find_input_clips
from twistcore.batch.manifest import Manifest
from twistcore.batch.parameters import Parameters
from twistcore.batch.run import run_batch
from twistcore.batch.stored_rows import parse_stored_decisions, parse_stored_result
from twistcore.errors import FormatError
from twistcore.work.processes import map_in_processes

JUMP = {
    "chain": "LeftLeg", "start": 3, "stop": 9, "kind": "lone jump", "delta_deg": 139.6,
    "confidence": 0.5, "open": True, "joint": "LeftFoot", "turn_deg": 139.6, "speed_deg_s": 16752.0,
}  # fmt: skip
RESULT = {
    "schema": "twistcore.batch_clip/1", "frames": 10, "fps": 120.0, "seconds": 0.1,
    "severity": 0.0, "affected_frames": 6, "applied": 0, "left": [], "method": "consistency",
    "format": "bvh", "unchecked": "", "intervals": [JUMP], "counts": {}, "tau_deg": {},
    "degrees": {"max": 0.0, "rms": 0.0},
}  # fmt: skip


def test_a_lone_jump_is_told_with_its_joint_and_its_speed():
    assert parse_stored_result(json.dumps(RESULT))["intervals"] == [JUMP]
    for key, value in (("joint", None), ("speed_deg_s", None), ("speed_deg_s", "fast")):
        damaged = {k: v for k, v in JUMP.items() if k != key}
        if value is not None:
            damaged[key] = value
        with pytest.raises(FormatError, match=key):
            parse_stored_result(json.dumps(RESULT | {"intervals": [damaged]}))


def test_of_decisions_what_is_written_again_is_what_is_known():
    document = '{"accepted": 1, "rejected": 0, "undecided": 2, "also": [1e300]}'
    assert parse_stored_decisions(document) == {"accepted": 1, "rejected": 0, "undecided": 2}


def test_a_batch_reads_again_what_it_wrote_of_a_stretch(tmp_path):
    walk = tc.read_clip(ASSETS / "walk.bvh")
    motion = spun("LeftFoot", 200, 280, 180.0, walk.motion)
    (tmp_path / "in").mkdir()
    tc.write_clip(walk, motion, tmp_path / "in" / "clip.bvh")
    sources = find_input_clips([str(tmp_path / "in")], tmp_path / "out").sources
    run_batch(
        tmp_path / "out",
        sources,
        Parameters(),
        lambda tasks, _: map_in_processes(run_task, tasks, 1),
    )
    with Manifest.open(tmp_path / "out") as manifest:
        (record,) = manifest.records()
    kinds = {entry["kind"] for entry in record.result["intervals"]}
    assert {"stretch", "lone jump"} <= kinds
