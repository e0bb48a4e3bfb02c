"""Many clips: what is in each, worst first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from twistcore.analysis import analyse
from twistcore.batch.how_bad import severity
from twistcore.clip_files import clips_in
from twistcore.detection import DEFAULT_METHOD
from twistcore.export.exports_beside import without_exports
from twistcore.formats import read_clip
from twistcore.motion import Motion
from twistcore.processes import each, reason
from twistcore.rig import AS_FOUND, Rig
from twistcore.tuning import Profile


@dataclass(frozen=True)
class ClipSurvey:
    """A clip at a glance: frames, frames a second, intervals found, and their severity.

    problem: why it could not be looked at, else ''; unchecked: why nothing could be found in it,
    where that says nothing about it, else ''; missing_frames: see :class:`Clip`; unexamined: how
    many of its arms and legs no chain examines.
    """

    path: Path
    frames: int = 0
    fps: float = 0.0
    intervals: int = 0
    severity: float = 0.0
    problem: str = ""
    unchecked: str = ""
    missing_frames: int = 0
    unexamined: int = 0


def survey(
    path: Path, profile: Profile | None = None, rig_of: Callable[[Motion], Rig] | None = None
) -> ClipSurvey:
    """Read and analyse a clip, at a profile's τ where there is one; raises TwistError.

    rig_of: which chains a motion gets, if not those found.
    """
    clip, profile = read_clip(path), profile or Profile({})
    analysis = analyse(clip, rig=AS_FOUND if rig_of is None else rig_of(clip.motion))
    tau = profile.of(analysis.chains_and_limbs)
    found = analysis.detect(profile.method or DEFAULT_METHOD, tau_radians=tau)
    frames, fps = clip.motion.frames, clip.motion.fps
    bad, missing = severity(found), clip.missing_frames
    left_out = len(analysis.unexamined)
    return ClipSurvey(path, frames, fps, len(found), bad, "", found.not_examined, missing, left_out)


def survey_folder(
    folder: Path | str, profile: Profile | None = None, workers: int = 1
) -> list[ClipSurvey]:
    """All clips of a folder, worst first; those that cannot be read, last, say why.

    Less what this program wrote of one of them: `exports_beside.exports_among`.
    """
    paths = without_exports(clips_in(Path(folder)))
    found = [
        ClipSurvey(path, problem=reason(path, r)) if isinstance(r, Exception) else r
        for path, r in each(partial(survey, profile=profile), paths, workers)
    ]
    return sorted(found, key=lambda s: (bool(s.problem), -s.severity, s.path))
