"""Sessions and journals, damaged, and replayed onto the clip that they are of."""

from __future__ import annotations

import random
from contextlib import suppress
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from inspector.session import opening
from inspector.session.leftovers import (
    count_missing,
    decisions_in,
    leftover_has_more_decisions,
    read_leftover,
    same_review,
)
from inspector.session.session_files import decided_counts
from tests.fuzz.json_damage import damage_bytes, damaged_json
from tests.fuzz.trial import Kind
from twistcore.analysis.clip_analysis import ClipAnalysis, analyse
from twistcore.batch.decisions import count_decisions
from twistcore.detection.interval_offsets import new_constant_offset_interval
from twistcore.export.exported_clips import clip_name_from_session_file
from twistcore.files.encoding import json_bytes
from twistcore.formats.bvh import read_bvh
from twistcore.formats.clip import Clip
from twistcore.review import (
    Annotate,
    CarryOver,
    ChangeChains,
    Command,
    Decide,
    Decision,
    Edit,
    Insert,
    LeaveOut,
    Redetect,
    Remove,
    Review,
    Session,
    Settle,
    Sign,
    Track,
    Tracking,
    read_session,
)
from twistcore.review.folder_sessions import session_files_by_clip
from twistcore.review.journal import REDO, SCHEMA, UNDO, replay_journal, review_command_to_json
from twistcore.review.replay import accepted_motion, session_chains
from twistcore.review.session import session_bytes, session_document
from twistcore.skeleton.rig import Rig

ASSETS = Path(__file__).parents[2] / "assets"


@cache
def clip() -> Clip:
    return read_bvh(ASSETS / "walk_injected.bvh")


@cache
def analysis() -> ClipAnalysis:
    return analyse(clip())


def commands() -> list[Command]:
    """One of every kind at least, each possible after those before it."""
    found = tuple(analysis().detect())
    moved = new_constant_offset_interval("LeftForeArm", 10, 30, 0.4)
    tau = dict(analysis().detect().tau)
    rig = Rig(remove=("RightLeg",))
    left = {name: t for name, t in tau.items() if name != "RightLeg"}
    ramp = replace(moved, offset=np.linspace(0.1, 0.4, 20))
    return [
        Decide((1, 2), Decision.ACCEPTED, "A. Person", "2026-01-01T00:00:00+00:00"),
        Decide(
            (3, 4), Decision.REJECTED, "A. Person", "2026-01-01T00:00:00+00:00", False, "a reason"
        ),
        Sign((1,), "Another"),
        Annotate(2, "a note", "a reason"),
        Edit(1, replace(ramp, chain=found[0].chain)),
        Insert(moved),
        Remove(9),
        Redetect({"LeftForeArm": 0.1}, found, drag=1),
        LeaveOut(((5, 9), (20, 30))),
        Track(Tracking(("LeftArm", "LeftForeArm"), 1.0, 0.1, 0.0, False, "")),
        Track(Tracking((), 1.0, 0.1, 0.0, True, "walk", False, True)),
        CarryOver(Review.of(analysis().detect()).state.intervals, True),
        Settle(Review.of(analysis().detect()).state.intervals[:2]),
        ChangeChains(rig, left, ("LeftLeg",), found, "Without RightLeg"),
    ]


@cache
def _sessions() -> tuple[dict[str, Any], ...]:
    """Documents of reviews with this and that in them."""
    review = Review.of(analysis().detect())
    documents = [session_document(clip(), review.state)]
    for command in commands():
        review.do(command)
        documents.append(session_document(clip(), review.state))
    return tuple(documents)


@cache
def _lines() -> tuple[dict[str, Any], ...]:
    lines = [review_command_to_json(command) for command in commands()]
    return (*lines[:4], dict(UNDO), dict(REDO), *lines[4:], {"session": _sessions()[3]})


def _session(rng: random.Random) -> dict[str, bytes]:
    return {"walk_injected.twist.json": damaged_json(rng.choice(_sessions()), rng)}


def _shown(session: Path, sha256: str, kept: Session) -> None:
    """As the window goes on with it; the clip is read once only."""
    with mock.patch.object(opening, "_read", _opened):
        opening._with_session(session, sha256, kept, clip().path, lambda _: None)
        with suppress(opening.ClipMissingError):
            opening.analyse_session(session)


def _opened(
    path: Path, profile: Any, tell: Any, session: Session | None = None, seen: Any = None
) -> Any:
    rig, _ = opening._rig_of(session, clip().motion)
    known = analysis() if rig == analysis().rig else analysis().with_rig(rig)
    return opening.Analysed(clip(), known, Review.of(known.detect()))


def _read_session(folder: Path) -> object:
    path = folder / "walk_injected.twist.json"
    (folder / "walk_injected.bvh").symlink_to(clip().path)
    session_files_by_clip(folder)
    clip_name_from_session_file(path)
    decided_counts(folder / "walk_injected.bvh")
    kept, sha256 = opening.read_session_with_hash(path)
    count_decisions(path)
    _shown(path, sha256, kept)
    chains = session_chains(kept, clip())
    state = kept.state
    accepted_motion(clip(), chains, replace(state, tracking=None))  # which takes its seconds
    again = session_bytes(clip(), state)
    path.write_bytes(again)
    assert session_bytes(clip(), read_session(path).state) == again
    return state


def _journal(rng: random.Random) -> dict[str, bytes]:
    head = {"schema": SCHEMA, "steps": 2, "session": _sessions()[0]}
    lines: list[Any] = [head, *_lines()]
    if rng.random() < 0.3:
        body = lines[1:]
        rng.shuffle(body)
        lines[1:] = body
    texts = [json_bytes(line, indent=None) for line in lines]
    for _ in range(rng.choice((1, 1, 2, 5))):
        at = rng.randrange(len(lines)) if rng.random() < 0.9 else 0
        texts[at] = damaged_json(lines[at], rng).replace(b"\n", b" ") + b"\n"
    data = b"".join(texts)
    if rng.random() < 0.1:
        data = damage_bytes(data, rng)
    return {"walk_injected.twist.json.journal": data}


def _read_journal(folder: Path) -> object:
    path = folder / "walk_injected.twist.json.journal"
    decisions_in(path)
    recovered = replay_journal(path, clip())
    state = recovered.review.state
    session_bytes(clip(), state)
    leftover, _ = read_leftover(path, clip(), analysis())
    if leftover is not None:
        fresh = Review.of(analysis().detect()).state
        leftover_has_more_decisions(leftover, clip(), fresh)
        count_missing(leftover, fresh)
        if leftover.same_clip:
            same_review(clip(), leftover.recovered.review.state, state)
            chains = state.rig.chains(clip().motion)
            accepted_motion(clip(), chains, replace(state, tracking=None))
    return recovered


KINDS = (Kind("session", _session, _read_session), Kind("journal", _journal, _read_journal))
