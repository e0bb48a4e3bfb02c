"""Axial twist errors in skeleton motion: find, judge, remove.

The order of the data:
read_clip → find_chains, find_limbs → analyse, detect → Review → refine → write_clip.
"""

from twistcore.analysis import ClipAnalysis, Detection, analyse, detect
from twistcore.batch import ClipSurvey, survey_folder
from twistcore.bvh import read_bvh, write_motion
from twistcore.chain import Chain, find_chains
from twistcore.clip import Clip, write_clip
from twistcore.detection import Interval, Kind
from twistcore.errors import TwistError
from twistcore.formats import read_clip
from twistcore.limb import Limb, find_limbs
from twistcore.motion import Motion, Skeleton
from twistcore.refinement import refine
from twistcore.review import Decision, Review, read_session, write_session
from twistcore.rig import OwnChain, Rig
from twistcore.signals import TwistSignals, twist_signals
from twistcore.version import __version__

write_bvh = write_clip  # its name before there were other formats

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
    "read_clip",
    "read_session",
    "refine",
    "survey_folder",
    "twist_signals",
    "write_bvh",
    "write_clip",
    "write_motion",
    "write_session",
]
