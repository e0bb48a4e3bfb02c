"""AMASS's .npz: poses on SMPL's joints, read with their names and rewritten where corrected."""

from twistcore.npz.npz_clip import NpzClip
from twistcore.npz.npz_reader import parse_npz, read_npz

__all__ = ["NpzClip", "parse_npz", "read_npz"]
