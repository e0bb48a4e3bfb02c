"""Survey many clips and sort them by the severity of their errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from twistcore.analysis.clip_analysis import analyse
from twistcore.analysis.clip_severity import measure_clip_severity
from twistcore.detection import DEFAULT_METHOD
from twistcore.export.exported_clips import exclude_previously_exported_clips
from twistcore.formats.clip_files import clip_paths_in_folder
from twistcore.formats.reading import read_clip
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rig import AS_FOUND, Rig
from twistcore.tuning import Profile
from twistcore.tuning.stated_precision import (
    AutomaticCorrection,
    automatic_corrections_with_confidence,
)
from twistcore.work.processes import describe_failure, map_in_processes
from twistcore.work.progress import Tell


@dataclass(frozen=True)
class ClipSurvey:
    """The summary of a clip, as returned by `survey_folder` for each file.

    Parameters
    ----------
    path : Path
        The file.
    frames : int
        Number of frames.
    fps : float
        Frames per second.
    intervals : int
        Number of intervals found.
    severity : float
        The root mean square of all visible errors over the frames, in degrees.
    problem : str
        The reason why the clip could not be read, or an empty string.
    unchecked : str
        The reason why no part of the clip could be examined, or an empty string.
    missing_frames : int
        Number of frames that the header declares but that are missing from the file.
    unexamined : int
        Number of arms and legs that were not examined, because no chain covers them.
    automatic : tuple of AutomaticCorrection
        The intervals that are corrected automatically, with their confidences.

    Examples
    --------
    >>> from pathlib import Path
    >>> import twistcore as tc
    >>> tc.ClipSurvey(Path("walk.bvh"), frames=344, fps=120.0).intervals
    0
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
    automatic: tuple[AutomaticCorrection, ...] = ()


def survey_clip(
    path: Path, profile: Profile | None = None, rig_of: Callable[[Motion], Rig] | None = None
) -> ClipSurvey:
    """Read and analyse a clip, and return its summary.

    Parameters
    ----------
    path
        The clip.
    profile
        The detector and the τ of each chain. By default, τ is automatic.
    rig_of
        A function that returns the rig for a motion. By default, the chains are found
        automatically.

    Raises
    ------
    TwistError
        If the clip cannot be read or analysed.
    """
    clip, profile = read_clip(path), profile or Profile({})
    analysis = analyse(clip, rig=AS_FOUND if rig_of is None else rig_of(clip.motion))
    tau = profile.of(analysis.chains_and_limbs)
    found = analysis.detect(profile.method or DEFAULT_METHOD, tau_radians=tau)
    frames, fps = clip.motion.frames, clip.motion.fps
    bad, missing = measure_clip_severity(found), clip.missing_frames
    return ClipSurvey(
        path,
        frames,
        fps,
        len(found),
        bad,
        unchecked=found.not_examined,
        missing_frames=missing,
        unexamined=len(analysis.unexamined),
        automatic=automatic_corrections_with_confidence(found),
    )


def survey_folder(
    folder: Path | str,
    profile: Profile | None = None,
    workers: int = 1,
    *,
    tell: Tell | None = None,
) -> list[ClipSurvey]:
    """Survey all clips in a folder, with the worst clip first.

    Clips that this program exported from other clips in the folder are skipped.

    Parameters
    ----------
    folder : str or Path
        The folder with the clips; subfolders are not searched.
    profile : Profile, optional
        τ for each chain, as written by `twistcore tune`. By default, τ is automatic.
    workers : int
        Number of processes.
    tell : callable, optional
        A function that is called after each clip with the completed fraction of the clips, 0…1.

    Returns
    -------
    list of ClipSurvey
        Sorted by severity; unreadable clips come last, with the reason in `problem`. Empty if there
        is no clip or no such folder.

    Raises
    ------
    OSError
        If the folder cannot be listed.

    Examples
    --------
    >>> import twistcore as tc
    >>> worst, *others = tc.survey_folder("assets")
    >>> worst.path.name, worst.intervals
    ('kick.bvh', 16)
    """
    paths = exclude_previously_exported_clips(clip_paths_in_folder(Path(folder)))
    found = []
    for path, r in map_in_processes(partial(survey_clip, profile=profile), paths, workers):
        found.append(
            ClipSurvey(path, problem=describe_failure(path, r)) if isinstance(r, Exception) else r
        )
        if tell is not None:
            tell(len(found) / len(paths))
    return sorted(found, key=lambda s: (bool(s.problem), -s.severity, s.path))
