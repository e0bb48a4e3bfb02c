"""Rotate every bent limb onto its usual hinge axis, the simplest anatomical correction."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from twistcore.detection.evidence import ChainSignals
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array

HINGE = "hinge"
LABEL = "hinge, frame by frame"
WHY = (
    "where the limb is bent by 10° or more, turns P so that C bends to its usual side, and turns C "
    "back; mistakes pronation and rotation of the joint for errors"
)
_CLEAR, _BENT = 30.0, 10.0  # smallest bends, degrees, to measure the hinge and to correct to it
_FEWEST = 0.1  # minimum duration of bends in which the hinge is measured, seconds


def benchmark_hinge_correction_offsets(motion: Motion, chains: Sequence[Chain]) -> dict[str, Array]:
    """Return the offsets to remove from chains with a hinge joint, keyed by chain name.

    Each offset is an array in radians, shape (frames,).
    """
    out = {}
    for chain in chains:
        known = ChainSignals.of(motion, chain)
        clear = known.bend > _CLEAR
        if not known.hinged or clear.sum() < max(_FEWEST * motion.fps, 1.0):
            continue
        turned = np.exp(1j * np.radians(known.azimuth))
        middle = np.angle(turned[clear].sum())
        aside = np.angle(turned * np.exp(-1j * middle))
        aside = np.angle(turned * np.exp(-1j * (middle + np.median(aside[clear]))))
        # A twist of the parent by δ changes the azimuth by −δ.
        out[chain.name] = np.where(known.bend > _BENT, -aside, 0.0)
    return out
