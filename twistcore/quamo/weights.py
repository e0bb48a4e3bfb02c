"""Where the shipped networks are, and what their files are called."""

from __future__ import annotations

from pathlib import Path

_PACKAGED = Path(__file__).resolve().parent / "weights"  # where a wheel has them
_IN_CHECKOUT = Path(__file__).resolve().parents[2] / "assets" / "quamo"
WEIGHTS = _PACKAGED if _PACKAGED.is_dir() else _IN_CHECKOUT
FINAL = "none"  # what the network trained on all subjects holds out


def weights_name(variant: str, subject: str, seed: int = 0) -> str:
    """File name of a network by variant and held-out subject."""
    return f"{variant}-{'all' if subject == FINAL else f'without-{subject}'}-{seed}.npz"


def weights_file() -> Path:
    """The network for any clip: trained on all subjects, the full variant."""
    return WEIGHTS / weights_name("full", FINAL)
