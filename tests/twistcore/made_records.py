"""Records of a batch with what is found in real clips, made without a batch."""

from __future__ import annotations

import numpy as np

from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.correction.twist_removal import automatic_corrections, refine
from twistcore.batch.manifest import ClipRecord
from twistcore.detection import Kind
from twistcore.files.version import __version__
from twistcore.formats.clip import write_clip
from twistcore.formats.reading import read_clip
from twistcore.skeleton.limb import Limb


def failed(name, reason):
    return _record(f"/captures/{name}", name, state="failed", reason=reason)


def waiting(name):
    return _record(f"/captures/{name}", name, state="waiting")


def _record(source, name, **more):
    usual = {
        "state": "done", "reason": "", "sha256": "", "bytes": 0, "seconds": 0.0, "peak_bytes": 0,
        "finished_at": "2026-01-02T10:00:00+00:00", "parameters": {}, "version": __version__,
        "result": None, "corrected": "", "decisions": {},
    }  # fmt: skip
    return ClipRecord(source, name, **usual | more)


def record_of(path, name, *, source=None, refine=None, decisions=None, **parameters):
    """A clip processed now; refine: the batch's folder, where its corrected clip is put."""
    clip = read_clip(path)
    found = analyse(clip).detect()
    result = _result(clip, found, name)
    corrected = ""
    if refine is not None:
        corrected = f"corrected/{name}"
        _correct(clip, found, refine / corrected)
        again = analyse(read_clip(refine / corrected)).detect()
        left = {"applied": len(automatic_corrections(found)), "left": _entries(again)}
        result |= left
    return _record(
        str(source or path), name, sha256=clip.sha256, result=result, corrected=corrected,
        parameters={"method": "consistency", "kinds": [], "refine": refine is not None,
                    **parameters},
        decisions=decisions or {},
    )  # fmt: skip


def _correct(clip, found, target):
    target.parent.mkdir(parents=True)
    write_clip(
        clip, refine(clip.motion, found.chains_and_limbs, automatic_corrections(found)), target
    )


def _result(clip, found, name):
    motion = clip.motion
    wrong, degrees = np.zeros(motion.frames, bool), [0.0]
    for interval in automatic_corrections(found, 0.0, include_open=True):
        wrong[interval.start : interval.stop] = True
        degrees += np.degrees(np.abs(interval.offset)).tolist()
    return {
        "schema": "twistcore.batch_clip/1", "clip": name, "sha256": clip.sha256,
        "format": clip.format, "frames": motion.frames, "fps": motion.fps,
        "seconds": motion.frames * motion.frame_time, "joints": len(motion.skeleton),
        "method": found.method,
        "tau_deg": {k: float(np.degrees(t)) for k, t in found.tau.items()},
        "intervals": _entries(found),
        "counts": {kind.value: sum(i.kind == kind for i in found) for kind in Kind},
        "affected_frames": int(wrong.sum()), "severity": sum(degrees) / motion.frames,
        "degrees": {"max": max(degrees), "rms": float(np.sqrt(np.mean(np.square(degrees))))},
        "chains": [c.name for c in found.chains_and_limbs], "unchecked": found.not_examined,
        "unexamined": [limb.to_json() for limb in found.analysis.unexamined], "warnings": [],
        "applied": None, "left": None, "quality": {},
    }  # fmt: skip


def _entries(found):
    chains = {chain.name: chain for chain in found.chains_and_limbs}
    names = found.analysis.motion.skeleton.names
    out = []
    for i in found:
        chain = chains[i.chain]
        entry = {
            "chain": names[chain.parent], "start": i.start, "stop": i.stop,
            "delta_deg": float(np.degrees(i.delta)), "confidence": i.confidence, "open": i.open,
            "kind": i.kind.value,
        }  # fmt: skip
        entry |= {"limb": chain.name} if isinstance(chain, Limb) else {}
        out.append(entry | (i.evidence or {} if i.kind == Kind.LONE_JUMP else {}))
    return out
