"""Reduce a clip's frame rate by dropping rows. The bytes of the remaining rows do not change."""

from __future__ import annotations

from twistcore.formats.bvh.clip import BvhClip
from twistcore.formats.bvh.reader import parse_bvh, timing_fields


def decimated(clip: BvhClip, step: int) -> BvhClip:
    """Return a clip with every step-th frame, starting with frame 0, at the rate fps / step."""
    if step == 1:
        return clip
    frames, columns = clip.values.shape
    starts, _ = clip.token_spans
    heads = [*(int(s) for s in starts[: frames * columns : columns]), len(clip.text)]
    kept = range(0, frames, step)
    (f0, f1), (t0, t1) = timing_fields(clip.text)
    pieces = [
        clip.text[:f0],
        str(len(kept)).encode(),
        clip.text[f1:t0],
        f"{clip.motion.frame_time * step:.9g}".encode(),
        clip.text[t1 : heads[0]],
        *(clip.text[heads[k] : heads[k + 1]] for k in kept),
    ]
    return parse_bvh(b"".join(pieces), clip.path)
