"""Register BVH, Biovision's text format with skeleton and joint angles, the most common one."""

from twistcore.formats.suffixes import FormatInfo

FORMAT = FormatInfo(".bvh", read="twistcore.formats.bvh:read_bvh", place=10)
