"""Register PKL: pickles with SMPL poses, as in AIST++. They are read without being executed."""

from twistcore.formats.suffixes import FormatInfo

FORMAT = FormatInfo(
    ".pkl",
    read="twistcore.formats.npz:read_pkl",
    place=40,
    without_motion="twistcore.formats.npz.other_data:pickle_without_poses",
)
