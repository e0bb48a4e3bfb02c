"""Poses on SMPL's joints in an .npz or a pickle, read by name; only corrections are rewritten."""

from twistcore.formats.npz.clip import NpzClip, PklClip
from twistcore.formats.npz.reader import parse_npz, parse_pkl, read_npz, read_pkl

__all__ = ["NpzClip", "PklClip", "parse_npz", "parse_pkl", "read_npz", "read_pkl"]
