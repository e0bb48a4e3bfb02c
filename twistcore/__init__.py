"""Find, judge and remove axial twist errors in skeleton motion.

The usual steps are read_clip → find_chains, find_limbs → analyse, detect → Review → refine →
write_clip.
"""

from importlib import import_module
from typing import TYPE_CHECKING

from twistcore.files.version import __version__

if TYPE_CHECKING:
    from twistcore.analysis.clip_analysis import ClipAnalysis, Detection, analyse, detect
    from twistcore.analysis.correction.twist_removal import refine
    from twistcore.batch import ClipSurvey, survey_folder
    from twistcore.detection import Interval, Kind
    from twistcore.errors import TwistError
    from twistcore.formats.bvh import read_bvh, write_motion
    from twistcore.formats.clip import Clip, write_clip
    from twistcore.formats.clip import write_clip as write_bvh  # noqa: F401  # its earlier name
    from twistcore.formats.reading import read_clip
    from twistcore.quamo import Tracker
    from twistcore.review import Decision, Review, read_session, write_session
    from twistcore.skeleton.chain import Chain, find_chains
    from twistcore.skeleton.limb import Limb, find_limbs
    from twistcore.skeleton.motion import Motion, Skeleton
    from twistcore.skeleton.rig import OwnChain, Rig
    from twistcore.skeleton.rotation import swing_twist
    from twistcore.skeleton.signals import TwistSignals, twist_signals
    from twistcore.synthesis import InjectedError, inject

# In the order in which the functions are used, as in the documentation.
__all__ = [  # noqa: RUF022
    "read_clip",
    "read_bvh",
    "Clip",
    "Motion",
    "Skeleton",
    "find_chains",
    "Chain",
    "find_limbs",
    "Limb",
    "Rig",
    "OwnChain",
    "twist_signals",
    "TwistSignals",
    "swing_twist",
    "analyse",
    "ClipAnalysis",
    "detect",
    "Detection",
    "Interval",
    "Kind",
    "Review",
    "Decision",
    "read_session",
    "write_session",
    "refine",
    "write_clip",
    "write_motion",
    "inject",
    "InjectedError",
    "Tracker",
    "survey_folder",
    "ClipSurvey",
    "TwistError",
    "__version__",
]

if not TYPE_CHECKING:
    # Loaded on first use: numpy and scipy take half a second, and a program that only counts clips,
    # such as the parent of many processes, needs neither.
    _HOMES = {
        "analysis.clip_analysis": "ClipAnalysis Detection analyse detect",
        "analysis.correction.twist_removal": "refine",
        "batch": "ClipSurvey survey_folder",
        "detection": "Interval Kind",
        "errors": "TwistError",
        "formats.bvh": "read_bvh write_motion",
        "formats.clip": "Clip write_clip",
        "formats.reading": "read_clip",
        "quamo": "Tracker",
        "review": "Decision Review read_session write_session",
        "skeleton.chain": "Chain find_chains",
        "skeleton.limb": "Limb find_limbs",
        "skeleton.motion": "Motion Skeleton",
        "skeleton.rig": "OwnChain Rig",
        "skeleton.rotation": "swing_twist",
        "skeleton.signals": "TwistSignals twist_signals",
        "synthesis": "InjectedError inject",
    }
    _ROOMS = {home.partition(".")[0] for home in _HOMES}

    def __getattr__(name: str) -> object:
        if name == "write_bvh":  # the name of write_clip when BVH was the only format
            name = "write_clip"
        for module, names in _HOMES.items():
            if name in names.split():
                return getattr(import_module(f"{__name__}.{module}"), name)
        if name in _ROOMS:
            return import_module(f"{__name__}.{name}")
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})
