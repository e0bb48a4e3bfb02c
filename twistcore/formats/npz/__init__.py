"""Read SMPL poses from .npz and pickle files, and rewrite the corrected numbers."""

from twistcore.formats.npz.clip import NpzClip, PklClip
from twistcore.formats.npz.reader import parse_npz, parse_pkl, read_npz, read_pkl

__all__ = ["NpzClip", "PklClip", "parse_npz", "parse_pkl", "read_npz", "read_pkl"]
