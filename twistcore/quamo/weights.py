"""The file names and paths of the networks that are part of the program."""

from __future__ import annotations

from pathlib import Path

_PACKAGED = Path(__file__).resolve().parent / "weights"  # the folder in a wheel
_IN_CHECKOUT = Path(__file__).resolve().parents[2] / "assets" / "quamo"
WEIGHTS = _PACKAGED if _PACKAGED.is_dir() else _IN_CHECKOUT
FINAL = "none"  # stands for the held-out subject of the network trained on all subjects


def gain_network_file_name(variant: str, subject: str, seed: int = 0) -> str:
    """Return the file name of a network, given its variant, held-out subject and random seed."""
    return f"{variant}-{'all' if subject == FINAL else f'without-{subject}'}-{seed}.npz"


def default_gain_network_path() -> Path:
    """Return the path of the default network: the full variant, trained on all subjects."""
    return WEIGHTS / gain_network_file_name("full", FINAL)
