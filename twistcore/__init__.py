"""Axial twist errors in skeleton motion: find, judge, remove.

The order of the data:
read_bvh → find_chains → analyse, detect → Review → refine → write_bvh.
"""

from twistcore.analysis import ClipAnalysis, Detection, analyse, detect
from twistcore.bvh import read_bvh, write_bvh
from twistcore.chain import find_chains
from twistcore.refinement import refine
from twistcore.review import Review
from twistcore.signals import twist_signals
from twistcore.version import __version__

__all__ = [
    "ClipAnalysis",
    "Detection",
    "Review",
    "__version__",
    "analyse",
    "detect",
    "find_chains",
    "read_bvh",
    "refine",
    "twist_signals",
    "write_bvh",
]
