"""Register BVH: Biovision's text format for a skeleton and joint angles, the most common format."""

from twistcore.formats.suffixes import FormatInfo

FORMAT = FormatInfo(".bvh", read="twistcore.formats.bvh:read_bvh", place=10)
