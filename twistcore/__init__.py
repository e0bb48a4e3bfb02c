"""Axial twist errors in skeleton motion: find, judge, remove.

The order of the data:
read_bvh → find_chains, find_limbs → analyse, detect → Review → refine → write_bvh.
"""

from twistcore.analysis import ClipAnalysis, Detection, analyse, detect
from twistcore.batch import ClipSurvey, survey_folder
from twistcore.bvh import Clip, read_bvh, write_bvh, write_motion
from twistcore.chain import Chain, find_chains
from twistcore.detection import Interval, Kind
from twistcore.errors import TwistError
from twistcore.limb import Limb, find_limbs
from twistcore.motion import Motion, Skeleton
from twistcore.refinement import refine
from twistcore.review import Decision, Review, read_session, write_session
from twistcore.rig import OwnChain, Rig
from twistcore.signals import TwistSignals, twist_signals
from twistcore.version import __version__

__all__ = [
    "Chain",
    "Clip",
    "ClipAnalysis",
    "ClipSurvey",
    "Decision",
    "Detection",
    "Interval",
    "Kind",
    "Limb",
    "Motion",
    "OwnChain",
    "Review",
    "Rig",
    "Skeleton",
    "TwistError",
    "TwistSignals",
    "__version__",
    "analyse",
    "detect",
    "find_chains",
    "find_limbs",
    "read_bvh",
    "read_session",
    "refine",
    "survey_folder",
    "twist_signals",
    "write_bvh",
    "write_motion",
    "write_session",
]
