"""Biovision's text format with a skeleton and joint angles, the format of most clips."""

from twistcore.formats.suffixes import FormatInfo

FORMAT = FormatInfo(".bvh", read="twistcore.formats.bvh:read_bvh", place=10)
