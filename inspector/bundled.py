"""Where the clips and texts that come with the program are: in a wheel, or in a checkout."""

from __future__ import annotations

from pathlib import Path

_PACKAGED = Path(__file__).resolve().parent / "assets"
_IN_CHECKOUT = Path(__file__).resolve().parents[1] / "assets"
ASSETS = _PACKAGED if _PACKAGED.is_dir() else _IN_CHECKOUT
SAMPLE = ASSETS / "walk_injected.bvh"
FLIPPED = ASSETS / "kick.bvh"  # with flips of a leg, as captured
PAGES = ASSETS / "tour"
EXERCISES = tuple(ASSETS / name for name in ("dance.bvh", "basketball.bvh", "walk.bvh"))
