"""The intervals of a clip as `detect --json` and a batch's results have them."""

from __future__ import annotations

import math
from typing import Any

from twistcore.analysis import Detection
from twistcore.limb import Limb


def intervals_to_json(found: Detection, *, explain: bool = False) -> list[dict[str, Any]]:
    """One entry an interval; explain: with what is left over and the evidence (docs/formats.md)."""
    chains = {chain.name: chain for chain in found.chains_and_limbs}
    names = found.analysis.motion.skeleton.names
    intervals = []
    for i in found:
        chain = chains[i.chain]
        entry: dict[str, Any] = {
            "chain": names[chain.parent],
            "parent": names[chain.parent],
            "child": names[chain.child],
            "start": i.start,
            "stop": i.stop,
            "delta_deg": math.degrees(i.delta),
            "confidence": i.confidence,
            "open": i.open,
            "kind": i.kind.value,
        }
        if chain.person:
            entry["person"] = chain.person
        if isinstance(chain, Limb):
            entry |= {"limb": chain.name, "end": names[chain.end], "carried": i.carried}
        if not i.repairable:
            entry |= i.evidence or {}
        if explain:
            entry["residual_deg"] = math.degrees(i.residual)
            entry["evidence"] = i.evidence
        intervals.append(entry)
    return intervals


def tau_to_json(found: Detection) -> dict[str, float]:
    """τ in degrees by the name of a chain or limb."""
    return {name: math.degrees(t) for name, t in found.tau.items()}
