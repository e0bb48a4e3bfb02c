"""Sessions and journals, damaged, and replayed onto the clip that they are of."""

from __future__ import annotations

import random
from functools import cache
from pathlib import Path

from tests.conftest import ASSETS
from tests.fuzz.json_damage import damaged_json
from tests.fuzz.trial import Kind
from twistcore.bvh import read_bvh
from twistcore.clip import Clip
from twistcore.review.session import read_session


@cache
def walk() -> Clip:
    return read_bvh(ASSETS / "walk_injected.bvh")


def _session(rng: random.Random) -> dict[str, bytes]:
    return {"a.twist.json": damaged_json({"schema": "twistcore.session/1"}, rng)}


def _read_session(folder: Path) -> object:
    return read_session(folder / "a.twist.json")


KINDS = (Kind("session", _session, _read_session),)
