"""Records of a batch as tests want them, without a batch."""

from __future__ import annotations

from typing import Any

from twistcore.batch.manifest import ClipRecord
from twistcore.detection import Kind


def interval(
    start: int = 10,
    stop: int = 20,
    degrees: float = 30.0,
    confidence: float | None = 0.9,
    kind: Kind = Kind.COUNTER_TWIST,
    **more: Any,
) -> dict[str, Any]:
    """An entry as of `detect --json`."""
    return {
        "chain": "LeftArm",
        "parent": "LeftArm",
        "child": "LeftForeArm",
        "start": start,
        "stop": stop,
        "delta_deg": degrees,
        "confidence": confidence,
        "open": False,
        "kind": kind.value,
        **more,
    }


def done(
    name: str,
    *intervals: dict[str, Any],
    frames: int = 100,
    severity: float = 0.0,
    result: dict[str, Any] | None = None,
    **more: Any,
) -> ClipRecord:
    """A clip in which these intervals were found, that lie apart."""
    found = {
        "schema": "twistcore.batch_clip/1",
        "clip": name,
        "sha256": "ab" * 32,
        "format": "bvh",
        "frames": frames,
        "fps": 120.0,
        "seconds": frames / 120.0,
        "joints": 31,
        "method": "consistency",
        "tau_deg": {"LeftArm": 5.0},
        "intervals": list(intervals),
        "counts": {kind.value: sum(i["kind"] == kind for i in intervals) for kind in Kind},
        "affected_frames": sum(
            i["stop"] - i["start"] for i in intervals if i["kind"] != Kind.LONE_JUMP
        ),
        "severity": severity,
        "degrees": {"max": 30.0, "rms": 20.0},
        "chains": ["LeftArm"],
        "unchecked": "",
        "warnings": [],
        "applied": None,
        "left": None,
        "quality": {"jitter": 0.5},
    }
    return record(name, result={**found, **(result or {})}, **more)


def record(name: str, **known: Any) -> ClipRecord:
    """A clip of a batch in any state."""
    plain: dict[str, Any] = {
        "source": f"/captures/{name}",
        "name": name,
        "state": "done",
        "reason": "",
        "sha256": "ab" * 32,
        "bytes": 1000,
        "seconds": 0.25,
        "peak_bytes": 10**8,
        "finished_at": "2026-01-02T03:04:05Z",
        "parameters": {},
        "version": "1",
        "result": None,
        "corrected": "",
        "decisions": {},
    }
    return ClipRecord(**{**plain, **known})


def failed(name: str, reason: str) -> ClipRecord:
    """A clip that could not be processed."""
    return record(name, state="failed", reason=reason)
