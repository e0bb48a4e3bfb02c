"""Axial twist errors in skeleton motion: find, judge, remove.

The order of the data:
read_bvh → find_chains, find_limbs → analyse, detect → Review → refine → write_bvh.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from twistcore.version import __version__

if TYPE_CHECKING:
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

if not TYPE_CHECKING:
    # Loaded when first asked for: numpy and scipy take half a second, and what only keeps count
    # of clips, as the parent of many processes does, needs neither.
    _HOMES = {
        "analysis": "ClipAnalysis Detection analyse detect",
        "batch": "ClipSurvey survey_folder",
        "bvh": "Clip read_bvh write_bvh write_motion",
        "chain": "Chain find_chains",
        "detection": "Interval Kind",
        "errors": "TwistError",
        "limb": "Limb find_limbs",
        "motion": "Motion Skeleton",
        "refinement": "refine",
        "review": "Decision Review read_session write_session",
        "rig": "OwnChain Rig",
        "signals": "TwistSignals twist_signals",
    }

    def __getattr__(name: str) -> object:
        for module, names in _HOMES.items():
            if name in names.split():
                globals()[name] = value = getattr(import_module(f"{__name__}.{module}"), name)
                return value
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
