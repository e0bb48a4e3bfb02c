"""`twistcore signals`: the curves in which errors are found, as CSV or JSON."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.cli.clip_inputs import (
    analysed,
    clip_name,
    failed_to_json,
    look_at,
    open_clip,
    tell_clip,
)
from twistcore.cli.interval_words import not_examined, note_sentences, unexamined_to_json
from twistcore.cli.output import note, print_json, refuse_overwrite, step, tell_problems
from twistcore.errors import TwistError
from twistcore.files.atomic import write_atomically
from twistcore.files.encoding import csv_lines, encoded
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.rotation import Array
from twistcore.skeleton.signals import TwistSignals

_COLUMNS = (
    "theta_p_deg", "theta_c_deg", "dtheta_p_deg", "dtheta_c_deg", "m_deg", "swing_reliability",
    "azimuth_reliability",
)  # fmt: skip
_DECIMALS = 6


def signals_command(arguments: argparse.Namespace) -> int:
    """Write the signals of clips, one row for each chain and frame; return the exit code."""
    if not (arguments.csv or arguments.json):
        raise TwistError("signals: has nothing to write; add --csv FILE or --json")
    if arguments.csv:
        rig = [path for path in (arguments.rig, arguments.joint_names) if path]
        refuse_overwrite([arguments.csv], [*arguments.clips, *rig])
    found, failed = look_at(arguments.clips, partial(_analysis, arguments))
    if found and arguments.csv:
        with step(f"  {arguments.csv}: written"):
            several = len(arguments.clips) > 1
            write_atomically(arguments.csv, encoded(_table(found, several=several)))
    if found and arguments.json:
        clips = [_to_json(name, analysis) for name, analysis in found]
        document = {"schema": "twistcore.signals/1", "clips": clips}
        print_json(document | {"failed": failed_to_json(failed)})
    blind = [sentence for name, one in found for sentence in not_examined(name, one)]
    for name, analysis in found:
        for sentence in note_sentences(name, analysis):
            note(sentence)
    return tell_problems([*blind, *(why for _, why in failed)], len(found))


def _analysis(arguments: argparse.Namespace, path: Path) -> tuple[str, ClipAnalysis]:
    clip = open_clip(path, fps=arguments.fps)
    tell_clip(clip_name(path), clip)
    analysis = analysed(arguments, clip)
    for name in arguments.chain or ():
        if isinstance(analysis.chain(name), Limb):
            raise TwistError(
                f"{clip_name(path)}: --chain {name} is a limb, and only chains have signals"
            )
    return clip_name(path), analysis


def _values(s: TwistSignals) -> Array:
    """Return the columns, shape (frames, 7)."""
    angles = np.degrees([s.theta_p, s.theta_c, s.dtheta_p, s.dtheta_c, s.strength]).T
    return np.hstack([angles, np.stack([s.swing_reliability, s.azimuth_reliability], axis=1)])


def _table(found: list[tuple[str, ClipAnalysis]], *, several: bool) -> str:
    return csv_lines(_rows(found, several=several))


def _rows(found: list[tuple[str, ClipAnalysis]], *, several: bool) -> Iterator[list[Any]]:
    yield [*(["clip"] if several else []), "chain", "frame", *_COLUMNS]
    for clip, analysis in found:
        for name, curves in analysis.signals.items():
            begin = [clip, name] if several else [name]
            for frame, row in enumerate(_values(curves).tolist()):
                yield [*begin, frame, *(f"{v:.{_DECIMALS}f}" for v in row)]


def _to_json(name: str, analysis: ClipAnalysis) -> dict[str, Any]:
    chains = []
    for chain, curves in analysis.signals.items():
        columns = zip(_COLUMNS, _values(curves).T.tolist(), strict=True)
        chains.append({"chain": chain} | {column: _rounded(v) for column, v in columns})
    motion = analysis.motion
    return {
        "clip": name,
        "frames": motion.frames,
        "fps": motion.fps,
        "not_examined": analysis.not_examined or None,
        "unexamined": unexamined_to_json(analysis),
        "chains": chains,
    }


def _rounded(values: list[float]) -> list[float | None]:
    """Return rounded values, None for angles that are not defined."""
    return [round(v, _DECIMALS) if math.isfinite(v) else None for v in values]
