"""Paths of the clips, texts and icons that are shipped with the program.

The files are in the package in an installed wheel, and in `assets` and `docs` in a checkout.
"""

from __future__ import annotations

from pathlib import Path

_PACKAGED = Path(__file__).resolve().parent / "assets"
_CHECKOUT = Path(__file__).resolve().parents[1]
ASSETS = _PACKAGED if _PACKAGED.is_dir() else _CHECKOUT / "assets"
DOCS = _PACKAGED / "docs" if _PACKAGED.is_dir() else _CHECKOUT / "docs"
SAMPLE = ASSETS / "walk_injected.bvh"
FLIPPED = ASSETS / "kick.bvh"  # a capture in which a leg flips
LANGUAGES = ASSETS / "languages"
LESSONS = ASSETS / "lessons"
TOUR = LESSONS / "tour.md"
EXERCISE_PAGE = ASSETS / "exercise.md"
ICONS = ASSETS / "icons"
EXERCISES = tuple(ASSETS / name for name in ("dance.bvh", "basketball.bvh", "walk.bvh"))
