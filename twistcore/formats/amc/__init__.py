"""Read and patch ASF/AMC: Acclaim's format for skeletons and motion, used by the CMU database."""

from twistcore.formats.amc.asf import Asf, parse_asf, read_asf
from twistcore.formats.amc.clip import AmcClip
from twistcore.formats.amc.reader import parse_amc, read_amc

__all__ = ["AmcClip", "Asf", "parse_amc", "parse_asf", "read_amc", "read_asf"]
