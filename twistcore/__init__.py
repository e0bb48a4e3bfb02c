"""Axial twist errors in skeleton motion: find, judge, remove.

The order of the data:
read_bvh → find_chains → twist_signals → detect → Review → refine → write_bvh.
"""

from twistcore.bvh import read_bvh, write_bvh, write_motion
from twistcore.chain import find_chains
from twistcore.detection import detect
from twistcore.refinement import refine
from twistcore.review import Review
from twistcore.signals import twist_signals
from twistcore.version import __version__

__all__ = [
    "Review",
    "__version__",
    "detect",
    "find_chains",
    "read_bvh",
    "refine",
    "twist_signals",
    "write_bvh",
    "write_motion",
]
