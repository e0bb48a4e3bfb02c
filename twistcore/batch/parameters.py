"""What clips are processed with: the options of `detect` and `refine`, as one thing with a mark."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from typing import Any

from twistcore.detection.registry import DEFAULT_METHOD
from twistcore.files.version import __version__
from twistcore.work.frozen import dataclass


@dataclass(frozen=True)
class Parameters:
    """Two runs with equal parameters and version make equal results of equal bytes.

    tau_deg: of all chains, None for automatic; profile_rad: τ by the name of a chain or limb, which
    goes before it, radians as a profile gives them; kinds: of errors, empty for all; chains: their
    names, empty for all; people: whose chains, empty for all; fps: instead of the file's; rig: as
    :func:`twistcore.skeleton.rig.rig_to_json`, or None; joint_names: a person's words, as
    :func:`twistcore.skeleton.joint_names.read_words` has them, or None; refine: whether a
    corrected clip is made, of intervals from min_confidence on and, with include_open, of open
    ones; detector_version: of a detector that is not the program's own.
    """

    method: str = DEFAULT_METHOD
    tau_deg: float | None = None
    profile_rad: Mapping[str, float] | None = None
    kinds: tuple[str, ...] = ()
    chains: tuple[str, ...] = ()
    people: tuple[str, ...] = ()
    fps: float | None = None
    rig: Mapping[str, Any] | None = None
    joint_names: Mapping[str, Any] | None = None
    refine: bool = False
    min_confidence: float | None = None
    include_open: bool = False
    detector_version: str = ""

    def to_json(self) -> dict[str, Any]:
        """As a manifest keeps them."""
        told = {field.name: getattr(self, field.name) for field in fields(self)}
        if not self.detector_version:  # as the program's own detectors have always been kept
            del told["detector_version"]
        return {k: list(v) if isinstance(v, tuple) else v for k, v in told.items()}

    @property
    def mark(self) -> str:
        """SHA-256 of parameters and version: what results belong to."""
        import hashlib  # slow to load; few commands need it

        text = json.dumps([__version__, self.to_json()], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()
