"""`twistcore tune`: τ per joint, from injected errors or from what people have decided."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from twistcore.cli.output import refuse_overwrite, tell_problems
from twistcore.errors import TwistError
from twistcore.processes import each, reason
from twistcore.rig import AS_FOUND, read_rig
from twistcore.tuning import TauCurve, clip_curves, tuned, write_profile
from twistcore.tuning.common_tau import common_tau
from twistcore.tuning.learned_profile import learned_profile
from twistcore.tuning.tau_curve import ALARM_PRICE, SMALLEST_ERROR
from twistcore.tuning.verdict_curve import ENOUGH_ERRORS
from twistcore.tuning.verdicts_of import JudgedClip, count, judged_in, sessions_in

_SEEDS = 3  # draws of errors


def tune(arguments: argparse.Namespace) -> int:
    """Write a profile of τ per joint from a clip or all clips of a folder."""
    return _by_verdicts(arguments) if arguments.verdicts else _by_injection(arguments)


def _by_injection(arguments: argparse.Namespace) -> int:
    source: Path = arguments.source
    if arguments.performer is not None:
        raise TwistError("--performer: expected --verdicts, too; an injected error is nobody's")
    paths = sorted(source.glob("*.bvh")) if source.is_dir() else [source]
    if not paths:
        raise TwistError(f"{source}: expected a BVH or a folder with some")
    refuse_overwrite([arguments.output], [*paths, *([arguments.rig] if arguments.rig else [])])
    rig = read_rig(arguments.rig) if arguments.rig else AS_FOUND
    seeds = _SEEDS if arguments.seeds is None else arguments.seeds
    work = partial(clip_curves, method=arguments.method, seeds=seeds, rig=rig)
    found: dict[Path, dict[str, TauCurve]] = {}
    problems: list[str] = []
    for path, result in each(work, paths, arguments.workers):
        if isinstance(result, Exception):
            problems.append(reason(path, result))
        elif not result:
            problems.append(f"{path}: no chain that τ could be tuned on")
        else:
            found[path] = result
            print(f"{path.name}: done", file=sys.stderr)
    code = tell_problems(problems, len(found))
    if not found:
        return code
    curves: dict[str, TauCurve] = {}
    for path in sorted(found):  # whichever process was first: the same profile
        for name, curve in found[path].items():
            curves[name] = curves[name] + curve if name in curves else curve
    price, smallest = _wanted(arguments)
    profile = {name: tuned(c, c.suggested(price, smallest)) for name, c in curves.items()}
    write_profile(arguments.output, profile, source.name, arguments.method)
    for name, t in profile.items():
        print(
            f"{name:<20} τ {t.tau:6.2f}°   noise {t.noise:6.3f}°   FSR {_known(t.fsr):>6} %   "
            f"{t.alarms_per_minute:.2f} false alarms a minute"
        )
    return code


def _known(percent: float) -> str:
    """A share, or a dash where no error could be put in to measure it with."""
    return "–" if math.isnan(percent) else f"{percent:.2f}"


def _wanted(arguments: argparse.Namespace) -> tuple[float, float]:
    """The price of an alarm, and the size of the smallest errors looked for, radians."""
    price, smallest = arguments.alarm_price, arguments.smallest
    return (
        ALARM_PRICE if price is None else price,
        SMALLEST_ERROR if smallest is None else math.radians(smallest),
    )


def _by_verdicts(arguments: argparse.Namespace) -> int:
    """τ from the sessions beside a folder's clips; the chains are each session's own."""
    folder: Path = arguments.source
    if not folder.is_dir():
        raise TwistError(f"{folder}: expected a folder of clips with their sessions")
    if arguments.rig:
        raise TwistError("--rig: expected no chains beside those of the sessions")
    if arguments.seeds is not None:
        raise TwistError("--seeds: expected none with --verdicts; nothing is drawn there")
    pairs = dict(sessions_in(folder))
    if not pairs:
        raise TwistError(f"{folder}: expected clips with sessions beside them, found none")
    refuse_overwrite([arguments.output], [*pairs, *pairs.values()])
    clips: list[JudgedClip] = []
    problems: list[str] = []
    for clip, result in each(partial(_judged, pairs), sorted(pairs), arguments.workers):
        if isinstance(result, Exception):
            problems.append(reason(clip, result))
        elif result.method != arguments.method:
            problems.append(f"{clip}: judged on what the {result.method} detector lists")
        elif arguments.performer in (None, result.performer):
            clips.append(result)
    if not clips and not problems:
        raise TwistError(f"{folder}: no session is of performer {arguments.performer!r}")
    code = tell_problems(problems, len(clips))
    if not clips:
        return code
    return _tell(arguments, sorted(clips, key=lambda c: c.name)) or code


def _judged(pairs: dict[Path, Path], clip: Path) -> JudgedClip:
    return judged_in(clip, pairs[clip])


def _tell(arguments: argparse.Namespace, clips: Sequence[JudgedClip]) -> int:
    """Write and print the profile; TwistError where too little is decided for one."""
    found = common_tau(clips, *_wanted(arguments), seed=0)
    errors, natural = count(clips)
    if found.common is None:
        raise TwistError(
            f"{arguments.source}: expected {ENOUGH_ERRORS} accepted intervals or more to learn τ "
            f"from, found {errors} accepted and {natural} rejected"
        )
    learnt = learned_profile(clips, found)
    learnt.write(arguments.output, arguments.source.name)
    print(f"{errors} accepted and {natural} rejected intervals in {len(clips)} clips")
    for name, tau in learnt.profile.tau.items():
        r = learnt.reasons[name]
        between = "" if math.isnan(r.low) else f"   ({r.low:.2f}–{r.high:.2f}°)"
        own = "   its own" if name in learnt.apart else ""
        print(
            f"{name:<20} τ {math.degrees(tau):6.2f}°   {r.accepted:4d} accepted   "
            f"{r.rejected:4d} rejected{between}{own}"
        )
    for sentence in (*found.words(), learnt.told_of_confidence()):
        print(sentence)
    return 0
