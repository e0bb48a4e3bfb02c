"""A process that measures the cost curves of a clip without blocking the window."""

from __future__ import annotations

import os
from dataclasses import dataclass
from multiprocessing import parent_process
from multiprocessing.connection import Connection
from pathlib import Path

from inspector.language import tr, translate_core_sentence, use_language
from inspector.language.catalogue import SOURCE
from twistcore.detection import DETECTORS
from twistcore.errors import TwistError
from twistcore.formats.reading import read_clip
from twistcore.skeleton.rig import Rig
from twistcore.tuning import Span, Verdicts, prepare_clip_tuning
from twistcore.work.with_parent import end_with_parent

_NICE = 5  # lower priority than the window


@dataclass(frozen=True, eq=False)
class Request:
    """A request to measure the cost of τ for some chains of a clip.

    Attributes
    ----------
    path, sha256
        The clip, and the SHA-256 of its file.
    method
        The name of the detector.
    verdicts
        The verdicts on the clip's intervals.
    wanted
        The names of the chains.
    rig
        The user's changes to the chains of the skeleton.
    left_out
        The frames to exclude from the measurement.
    draws
        The number of draws of random errors for each chain and protocol.
    detector
        The file and the class of the detector as 'FILE.py:Class', or '' if the detector is built in
        or installed.
    language
        The language of error messages.
    """

    path: Path
    sha256: str
    method: str
    verdicts: Verdicts
    wanted: tuple[str, ...]
    rig: Rig
    left_out: tuple[Span, ...]
    draws: int
    detector: str = ""
    language: str = SOURCE


@dataclass(frozen=True)
class Capture:
    """The frames of a clip in which the cost of τ is measured.

    Attributes
    ----------
    first, stop
        The range [first, stop), without the blends at the ends of the clip.
    presumed
        Intervals, as (chain, start, stop), without a verdict. They are counted as errors because
        the detector is certain of them.
    """

    first: int
    stop: int
    presumed: tuple[tuple[str, int, int], ...] = ()


def measure_cost_curves(pipe: Connection, request: Request) -> None:
    """Measure the requested cost curves, and send the results through the pipe.

    The results are a Capture, then a pair (chain, curve) for each chain, then None. If the
    measurement fails, an error message is sent instead. A chain name that is received through the
    pipe sets the chain to measure next.
    """
    if (parent := parent_process()) is not None and parent.pid:
        end_with_parent(parent.pid)
    if hasattr(os, "nice"):
        os.nice(_NICE)
    use_language(request.language)
    try:
        if request.detector:
            DETECTORS.load(request.detector)
        clip = read_clip(request.path)
        if clip.sha256 != request.sha256:
            changed = tr(
                "{clip} has changed on disk. Open it again to measure the cost of τ.",
                clip=clip.name,
            )
            pipe.send(changed)
            return
        tuning = prepare_clip_tuning(
            clip.motion,
            clip.name,
            method=request.method,
            seeds=range(request.draws),
            verdicts=request.verdicts,
            rig=request.rig,
            left_out=request.left_out,
        )
        stop = tuning.first + tuning.clean.motion.frames
        pipe.send(Capture(tuning.first, stop, tuning.presumed))
        left = [name for name in request.wanted if name in tuning.names]
        while left:
            while pipe.poll():
                first = pipe.recv()
                left.sort(key=lambda name: name != first)
            name = left.pop(0)
            pipe.send((name, tuning.curve(name)))
        pipe.send(None)
    except TwistError as error:
        pipe.send(translate_core_sentence(error))
    except (BrokenPipeError, EOFError):
        return  # the window has closed the pipe
    except Exception as error:  # report a bug; only this process ends
        pipe.send(f"{request.path.name}: {type(error).__name__}: {error}")
