"""Register NPZ: numpy archives with poses of SMPL body models, as in AMASS."""

from twistcore.formats.suffixes import FormatInfo

FORMAT = FormatInfo(
    ".npz",
    read="twistcore.formats.npz:read_npz",
    place=20,
    without_motion="twistcore.formats.npz.other_data:archive_without_poses",
)
