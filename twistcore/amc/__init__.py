"""ASF/AMC, Acclaim's skeleton and motion: the format that CMU's database is released in."""

from twistcore.amc.amc_clip import AmcClip
from twistcore.amc.amc_reader import parse_amc, read_amc
from twistcore.amc.asf import Asf, parse_asf, read_asf

__all__ = ["AmcClip", "Asf", "parse_amc", "parse_asf", "read_amc", "read_asf"]
