"""Keep, repeat or drop frames of a clip. The bytes of the remaining rows do not change."""

from __future__ import annotations

from collections.abc import Sequence

from twistcore.formats.bvh.clip import BvhClip
from twistcore.formats.bvh.reader import bvh_timing_number_spans, parse_bvh


def decimated(clip: BvhClip, step: int) -> BvhClip:
    """Return a clip with only every `step`-th frame, from frame 0, and a lower frame rate."""
    if step == 1:
        return clip
    return select_bvh_frames(clip, range(0, clip.frames, step), clip.motion.frame_time * step)


def select_bvh_frames(clip: BvhClip, kept: Sequence[int], frame_time: float) -> BvhClip:
    """Return a clip with the given frames of another clip. `frame_time` is in seconds."""
    frames, columns = clip.values.shape
    starts, _ = clip.token_spans
    heads = [*(int(s) for s in starts[: frames * columns : columns]), len(clip.text)]
    (f0, f1), (t0, t1) = bvh_timing_number_spans(clip.text)
    pieces = [
        clip.text[:f0],
        str(len(kept)).encode(),
        clip.text[f1:t0],
        f"{frame_time:.9g}".encode(),
        clip.text[t1 : heads[0]],
        *(clip.text[heads[k] : heads[k + 1]] for k in kept),
    ]
    return reparse_bvh(clip, b"".join(pieces))


def reparse_bvh(clip: BvhClip, text: bytes) -> BvhClip:
    """Parse the changed text of a clip. The encoding stays the same."""
    return parse_bvh(text if clip.wide is None else clip.wide.encoded(text), clip.path)
