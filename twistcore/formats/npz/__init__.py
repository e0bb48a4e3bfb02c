"""Read poses on SMPL's joints from an .npz or a pickle by array names, and rewrite corrections
only.
"""

from twistcore.formats.npz.clip import NpzClip, PklClip
from twistcore.formats.npz.reader import parse_npz, parse_pkl, read_npz, read_pkl

__all__ = ["NpzClip", "PklClip", "parse_npz", "parse_pkl", "read_npz", "read_pkl"]
