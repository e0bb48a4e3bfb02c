"""The processing parameters of a batch: the options of the commands `detect` and `refine`."""

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
    """The processing parameters of a batch.

    With the same parameters and program version, a file always has the same result.

    Parameters
    ----------
    method
        Name of the detector.
    tau_deg
        The threshold τ for all chains in degrees, None for an automatic τ.
    profile_rad
        τ in radians, keyed by the name of a chain or limb; overrides tau_deg.
    kinds
        Kinds of errors, empty for all.
    chains
        Names of chains, empty for all.
    people
        Names of people whose chains are examined, empty for all.
    fps
        Frame rate to use instead of the file's, or None.
    rig
        The user's changes to the chains, from :func:`twistcore.skeleton.rig.rig_to_json`, or None.
    joint_names
        The user's words for joints, from
        :func:`twistcore.skeleton.joint_names.read_joint_vocabulary_file`, or None.
    refine
        True to write corrected clips.
    min_confidence
        The lowest confidence of an interval that is corrected, or None for the default.
    include_open
        True to correct open intervals as well.
    detector_version
        Version of a detector from a plug-in, or '' for a built-in detector.
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
        """Return the parameters as stored in a manifest."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        if not self.detector_version:  # never stored for built-in detectors
            del values["detector_version"]
        return {k: list(v) if isinstance(v, tuple) else v for k, v in values.items()}

    @property
    def mark(self) -> str:
        """Return the SHA-256 of the parameters and the program version, as a key for results."""
        import hashlib  # slow to load; few commands need it

        text = json.dumps([__version__, self.to_json()], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()
