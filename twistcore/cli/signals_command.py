"""Run `twistcore signals`, which prints the signals in which errors are detected."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.cli.clip_inputs import (
    analyse_with_options,
    clip_name_for_messages,
    failed_clips_to_json,
    print_clip_notes,
    read_clip_or_stdin,
    run_on_clips_collecting_failures,
)
from twistcore.cli.interval_words import (
    note_sentences,
    nothing_examined_sentence,
    unexamined_limbs_to_json,
)
from twistcore.cli.output import (
    print_json,
    print_note,
    print_step_duration,
    refuse_overwrite,
    report_problems,
)
from twistcore.errors import TwistError
from twistcore.files.atomic import write_atomically
from twistcore.files.encoding import csv_lines, encode_utf8
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.rotation import Array
from twistcore.skeleton.signals import TwistSignals

_COLUMNS = (
    "theta_p_deg", "theta_c_deg", "dtheta_p_deg", "dtheta_c_deg", "m_deg", "swing_reliability",
    "azimuth_reliability",
)  # fmt: skip
_STRENGTH = "strength_deg"  # the strength that the chosen detector compares with τ
_DECIMALS = 6


class _Signals(NamedTuple):
    """The signals of a clip.

    Parameters
    ----------
    name
        The clip's name.
    analysis
        The analysis of the clip.
    columns
        The columns of each chain, keyed by chain name and column name, each of shape (frames,).
    """

    name: str
    analysis: ClipAnalysis
    columns: Mapping[str, Mapping[str, Array]]


def signals_command(arguments: argparse.Namespace) -> int:
    """Write the signals of the clips, a row for each chain and frame, and return the exit code."""
    if not (arguments.csv or arguments.json):
        raise TwistError("signals requires --csv FILE or --json")
    if arguments.csv:
        rig = [path for path in (arguments.rig, arguments.joint_names) if path]
        refuse_overwrite([arguments.csv], [*arguments.clips, *rig])
    found, failed = run_on_clips_collecting_failures(arguments.clips, partial(_signals, arguments))
    if found and arguments.csv:
        with print_step_duration(f"  {arguments.csv}: written"):
            several = len(arguments.clips) > 1
            write_atomically(arguments.csv, encode_utf8(_table(found, several=several)))
    if found and arguments.json:
        clips = [_to_json(name, analysis, columns) for name, analysis, columns in found]
        document = {"schema": "twistcore.signals/1", "clips": clips}
        print_json(document | {"failed": failed_clips_to_json(failed)})
    blind = [
        sentence for name, one, _ in found for sentence in nothing_examined_sentence(name, one)
    ]
    for name, analysis, _ in found:
        for sentence in note_sentences(name, analysis):
            print_note(sentence)
    return report_problems([*blind, *(why for _, why in failed)], len(found))


def _signals(arguments: argparse.Namespace, path: Path) -> _Signals:
    clip = read_clip_or_stdin(path, fps=arguments.fps)
    print_clip_notes(clip_name_for_messages(path), clip)
    analysis = analyse_with_options(arguments, clip)
    for name in arguments.chain or ():
        if isinstance(analysis.chain(name), Limb):
            raise TwistError(
                f"{clip_name_for_messages(path)}: {name} is a limb, but only chains have signals; "
                "choose a chain with --chain"
            )
    return _Signals(clip_name_for_messages(path), analysis, _columns(analysis, arguments.method))


def _columns(analysis: ClipAnalysis, method: str | None) -> dict[str, dict[str, Array]]:
    """Return the signals of each chain, keyed by chain name and column name, each (frames,).

    With a `method`, the strength that this detector compares with τ is added.
    """
    signals = analysis.signals
    columns = {chain: _of_chain(curves) for chain, curves in signals.items()}
    if method is not None:
        detector = analysis.detector(method)
        for chain, own in columns.items():
            own[_STRENGTH] = np.degrees(detector.strength(chain))
    return columns


def _of_chain(s: TwistSignals) -> dict[str, Array]:
    angles = np.degrees([s.theta_p, s.theta_c, s.dtheta_p, s.dtheta_c, s.strength])
    values = (*angles, s.swing_reliability, s.azimuth_reliability)
    return dict(zip(_COLUMNS, values, strict=True))


def _table(found: Sequence[_Signals], *, several: bool) -> str:
    return csv_lines(_rows(found, several=several))


def _rows(found: Sequence[_Signals], *, several: bool) -> Iterator[list[Any]]:
    heads = next((list(own) for one in found for own in one.columns.values()), _COLUMNS)
    yield [*(["clip"] if several else []), "chain", "frame", *heads]
    for clip, _, columns in found:
        for name, own in columns.items():
            begin = [clip, name] if several else [name]
            for frame, row in enumerate(np.stack(list(own.values()), axis=1).tolist()):
                yield [*begin, frame, *(f"{v:.{_DECIMALS}f}" for v in row)]


def _to_json(
    name: str, analysis: ClipAnalysis, columns: Mapping[str, Mapping[str, Array]]
) -> dict[str, Any]:
    chains = [
        {"chain": chain} | {head: _rounded(values.tolist()) for head, values in own.items()}
        for chain, own in columns.items()
    ]
    motion = analysis.motion
    return {
        "clip": name,
        "frames": motion.frames,
        "fps": motion.fps,
        "not_examined": analysis.not_examined or None,
        "unexamined": unexamined_limbs_to_json(analysis),
        "chains": chains,
    }


def _rounded(values: list[float]) -> list[float | None]:
    """Return the values rounded to 6 decimals, with None for undefined angles."""
    return [round(v, _DECIMALS) if math.isfinite(v) else None for v in values]
