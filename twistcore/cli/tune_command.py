"""Run `twistcore tune`, which finds τ for each chain from injected errors or from decisions."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from twistcore.cli.clip_inputs import chosen_joint_names
from twistcore.cli.output import (
    print_json,
    print_progress,
    print_result,
    refuse_overwrite,
    report_problems,
    terminal_text,
)
from twistcore.detection import DETECTORS
from twistcore.errors import TwistError
from twistcore.export.exported_clips import exclude_previously_exported_clips
from twistcore.files.ordinary import path_exists
from twistcore.formats.clip_files import clip_paths_in_folder
from twistcore.review.folder_sessions import FolderSessions, session_files_by_clip
from twistcore.skeleton.rig import AS_FOUND, Rig, read_rig
from twistcore.tuning import (
    TauCurve,
    clip_tau_curves,
    tau_with_cost,
    total_tuning_cost,
    write_profile,
)
from twistcore.tuning.common_tau import common_tau
from twistcore.tuning.cost_words import format_repaired_share
from twistcore.tuning.learned_profile import LearnedProfile, learned_profile
from twistcore.tuning.tau_curve import ALARM_PRICE, SMALLEST_ERROR
from twistcore.tuning.verdict_curve import ENOUGH_ERRORS, tau_curve_from_verdicts
from twistcore.tuning.verdicts_of import (
    JudgedClip,
    count_accepted_and_rejected_intervals,
    read_judged_clip,
)
from twistcore.work.processes import describe_failure, map_in_processes

_SEEDS = 3  # number of random draws of errors
_ALL = "all chains"

ByChain = Mapping[str, TauCurve]  # keyed by chain name


def tune_command(arguments: argparse.Namespace) -> int:
    """Write a profile with τ for each chain and return the exit code."""
    return _by_verdicts(arguments) if arguments.verdicts else _by_injection(arguments)


def _by_injection(arguments: argparse.Namespace) -> int:
    source: Path = arguments.source
    if arguments.performer is not None:
        raise TwistError(
            "--performer requires --verdicts, because injected errors have no performer"
        )
    paths = (
        exclude_previously_exported_clips(clip_paths_in_folder(source))
        if source.is_dir()
        else [source]
    )
    if not paths:
        raise TwistError(f"{source}: expected a clip or a folder with clips")
    sessions = FolderSessions({}, ())
    if arguments.sessions:
        _refuse_rig(arguments)
        sessions = _sessions_next_to(source, paths)
    problems = [one.why for one in sessions.damaged]
    rigs = [path for path in (arguments.rig, arguments.joint_names) if path]
    refuse_overwrite([arguments.output], [*paths, *sessions.files, *rigs])
    rig = read_rig(arguments.rig) if arguments.rig else AS_FOUND
    seeds = _SEEDS if arguments.seeds is None else arguments.seeds
    others = (
        [m for m in sorted(DETECTORS.ready()) if m != arguments.method] if arguments.both else []
    )
    methods = arguments.method, *others
    words = chosen_joint_names(arguments)
    work = partial(
        _curves, methods=methods, seeds=seeds, rig=rig, sessions=sessions.of, words=words
    )
    found: dict[Path, Mapping[str, ByChain]] = {}
    # A clip with a damaged session is left out, since its chains are unknown.
    mute = {one.clip for one in sessions.damaged} - sessions.of.keys()
    paths = [path for path in paths if path not in mute]
    for path, result in map_in_processes(work, paths, arguments.workers):
        if isinstance(result, Exception):
            problems.append(describe_failure(path, result))
        elif not result[arguments.method]:
            problems.append(f"{path} has no chain for which τ can be tuned")
        else:
            found[path] = result
            with_session = ", with its session" * (path in sessions.of)
            print_progress(f"{path.name}: done{with_session}")
    code = report_problems(problems, len(found))
    if not found:
        return code
    # The order of the clips must not depend on which process finished first.
    together = {m: _together(found[path][m] for path in sorted(found)) for m in methods}
    curves, wanted = together[arguments.method], _price_and_smallest(arguments)
    profile = {name: tau_with_cost(c, c.suggested(*wanted)) for name, c in curves.items()}
    write_profile(arguments.output, profile, source.name, arguments.method)
    minutes = sum(_minutes(clip[arguments.method]) for clip in found.values())
    both = _of_both(together, minutes, wanted) if arguments.both else _of_one(curves, wanted)
    if arguments.json:
        given = {"seeds": seeds, "clips": sorted(map(str, found)), "problems": problems}
        print_json(_tuned_to_json(arguments, together, wanted, given))
        return code
    for line in both:
        print_result(line.text, head=line.head)
    return code


class _Line(NamedTuple):
    text: str
    head: bool = False


def _tuned_to_json(
    arguments: argparse.Namespace,
    together: Mapping[str, ByChain],
    wanted: tuple[float, float],
    given: Mapping[str, Any],
) -> dict[str, Any]:
    """Return a JSON document with τ and its cost for every chain and every detector.

    `wanted` is the price of a false alarm and the smallest error to find. `given` has further keys.
    """
    price, smallest = wanted
    chains = []
    for method in sorted(together):
        for name, curve in together[method].items():
            tau = curve.suggested(*wanted)
            cost = curve.cost(tau)
            numbers = {
                "tau_deg": math.degrees(tau),
                "automatic_tau_deg": math.degrees(curve.automatic),
                "noise_deg": math.degrees(curve.floor),
                "fsr_percent": 100.0 * cost.fsr,
                "fsr_low_percent": 100.0 * cost.low,
                "fsr_high_percent": 100.0 * cost.high,
                "false_alarms_per_minute": cost.rate,
            }
            known = {k: v if math.isfinite(v) else None for k, v in numbers.items()}
            chains.append({"chain": name, "method": method, **known})
    return {
        "schema": "twistcore.tune/1",
        "source": str(arguments.source),
        "output": str(arguments.output),
        "method": arguments.method,
        "alarm_price": price,
        "smallest_deg": math.degrees(smallest),
        **given,
        "chains": chains,
    }


def _sessions_next_to(source: Path, paths: Sequence[Path]) -> FolderSessions:
    """Return the sessions of the clips `paths`, including damaged ones.

    Raises TwistError if there are no sessions.
    """
    folder = source if source.is_dir() else source.parent
    there = session_files_by_clip(folder)
    own = FolderSessions(
        {clip: session for clip, session in there.of.items() if clip in paths},
        tuple(one for one in there.damaged if one.clip in (*paths, folder)),
    )
    if path_exists(source) and not own.files:
        raise TwistError(f"{source}: expected clips with sessions next to them, found none")
    return own


def _curves(
    path: Path,
    methods: Sequence[str],
    seeds: int,
    rig: Rig,
    sessions: Mapping[Path, Path],
    words: Mapping[str, Any] | None,
) -> dict[str, ByChain]:
    """Return the τ curves of a clip for each detector, measured with the same injected errors."""
    return {m: clip_tau_curves(path, m, seeds, rig, sessions.get(path), words) for m in methods}


def _together(clips: Iterable[ByChain]) -> ByChain:
    """Return the sum of all clips' curves for each chain, keyed by chain name."""
    out: dict[str, TauCurve] = {}
    for clip in clips:
        for name, curve in clip.items():
            out[name] = out[name] + curve if name in out else curve
    return out


def _minutes(curves: ByChain) -> float:
    """Return how many minutes of a clip were examined, which is the maximum over its chains."""
    return max(curve.minutes for curve in curves.values())


def _of_one(curves: ByChain, wanted: tuple[float, float]) -> Iterator[_Line]:
    """Yield a table with τ and its cost, chain by chain, for one detector.

    The cost includes the FSR, the share of injected error frames that are repaired, with its
    confidence limits. `wanted` is the price of a false alarm and the smallest error to find.
    """
    width = max([20, *(len(terminal_text(name)) for name in curves)])
    yield _Line(
        f"{'chain':<{width}} {'τ':>9} {'noise':>9} {'FSR':>20} {'false alarms/min':>17}", True
    )
    for name, curve in curves.items():
        tau = curve.suggested(*wanted)
        cost, noise = curve.cost(tau), math.degrees(curve.floor)
        yield _Line(
            f"{terminal_text(name):<{width}} {math.degrees(tau):>8.2f}° {noise:>8.3f}° "
            f"{format_repaired_share(cost, 2):>20} {cost.rate:>17.2f}"
        )


def _of_both(
    together: Mapping[str, ByChain], minutes: float, wanted: tuple[float, float]
) -> Iterator[_Line]:
    """Yield a table that compares the suggested with the automatic τ for all detectors.

    `minutes` is the total duration of all clips, including clips that lack some chains. `wanted` is
    the price of a false alarm and the smallest error to find.
    """
    methods = sorted(together)
    names = list(dict.fromkeys(name for curves in together.values() for name in curves))
    width = max(map(len, [*map(terminal_text, names), _ALL])) + 2
    heads = (f"{DETECTORS.info(m).label[:40]:<42}" for m in methods)
    yield _Line(f"{'':<{width}}{'':<11}{''.join(heads)}".rstrip(), True)
    columns = f"{'τ':>8}{'FSR % (95 %)':>18}{'alarms/min':>12}    "
    yield _Line(f"{'chain':<{width}}{'':<11}{columns * len(methods)}".rstrip(), True)
    for name in (*names, _ALL):
        for kind in ("suggested", "automatic"):
            line = f"{terminal_text(name) if kind == 'suggested' else '':<{width}}{kind:<11}"
            for m in methods:
                chosen = [
                    (c, c.suggested(*wanted) if kind == "suggested" else c.automatic)
                    for n, c in together[m].items()
                    if name in (n, _ALL)
                ]
                cost = total_tuning_cost(chosen, minutes if name == _ALL else None)
                tau = "" if name == _ALL else f"{math.degrees(chosen[0][1]):.2f}°"
                line += f"{tau:>8}{format_repaired_share(cost, unit=''):>18}{cost.rate:>12.2f}    "
            yield _Line(line.rstrip())


def _refuse_rig(arguments: argparse.Namespace) -> None:
    if arguments.rig:
        raise TwistError(
            "--rig cannot be combined with sessions, because the sessions contain the chains"
        )
    if arguments.joint_names:
        raise TwistError(
            "--joint-names cannot be combined with sessions, because the sessions contain the names"
        )


def _price_and_smallest(arguments: argparse.Namespace) -> tuple[float, float]:
    """Return the price of a false alarm, and the size of the smallest error to find, in radians."""
    price, smallest = arguments.alarm_price, arguments.smallest
    return (
        ALARM_PRICE if price is None else price,
        SMALLEST_ERROR if smallest is None else math.radians(smallest),
    )


def _by_verdicts(arguments: argparse.Namespace) -> int:
    """Tune τ on the decisions in the sessions of a folder, and return the exit code."""
    folder: Path = arguments.source
    if not folder.is_dir():
        raise TwistError(f"{folder}: expected a folder of clips with their sessions")
    _refuse_rig(arguments)
    for option in ("both", "sessions"):
        if getattr(arguments, option):
            raise TwistError(
                f"--{option} cannot be combined with --verdicts, because no errors are injected"
            )
    if arguments.seeds is not None:
        raise TwistError(
            "--seeds cannot be combined with --verdicts, because no errors are injected"
        )
    there = session_files_by_clip(folder)
    pairs, problems = dict(there.of), [one.why for one in there.damaged]
    if not there.files:
        raise TwistError(f"{folder}: expected clips with sessions next to them, found none")
    refuse_overwrite([arguments.output], [*pairs, *there.files])
    clips: list[JudgedClip] = []
    for clip, result in map_in_processes(partial(_judged, pairs), sorted(pairs), arguments.workers):
        if isinstance(result, Exception):
            problems.append(describe_failure(clip, result))
        elif result.method != arguments.method:
            problems.append(
                f"{clip} was judged with the detector {result.method}; choose this detector "
                "with --method"
            )
        elif arguments.performer in (None, result.performer):
            clips.append(result)
    if not clips and not problems:
        raise TwistError(f"{folder}: no session has the performer {arguments.performer!r}")
    code = report_problems(problems, len(clips))
    if not clips:
        return code
    return _tell(arguments, sorted(clips, key=lambda c: c.name), problems) or code


def _judged(pairs: dict[Path, Path], clip: Path) -> JudgedClip:
    return read_judged_clip(clip, pairs[clip])


def _tell(
    arguments: argparse.Namespace, clips: Sequence[JudgedClip], problems: Sequence[str]
) -> int:
    """Write and print the profile. Raises TwistError if there are too few decisions."""
    found = common_tau(clips, *_price_and_smallest(arguments), seed=0)
    errors, natural = count_accepted_and_rejected_intervals(clips)
    curve = tau_curve_from_verdicts(clips)
    if found.common is None and curve.enough:
        raise TwistError(f"{arguments.source}: {curve.one_sided_sentence}")
    if found.common is None:
        raise TwistError(
            f"{arguments.source}: expected at least {ENOUGH_ERRORS} accepted intervals to learn "
            f"τ from, found {errors} accepted and {natural} rejected"
        )
    learnt = learned_profile(clips, found)
    learnt.write(arguments.output, arguments.source.name)
    sentences = [*found.words(), learnt.confidence_sentence()]
    if arguments.json:
        print_json(
            {
                "schema": "twistcore.tune_verdicts/1",
                "source": str(arguments.source),
                "output": str(arguments.output),
                "method": arguments.method,
                "performer": arguments.performer,
                "clips": [clip.name for clip in clips],
                "accepted": errors,
                "rejected": natural,
                "problems": list(problems),
                "chains": [_learnt_to_json(learnt, name) for name in learnt.profile.tau],
                "sentences": sentences,
            }
        )
        return 0
    print_result(f"{errors} accepted and {natural} rejected intervals in {len(clips)} clips")
    width = max([20, *(len(terminal_text(name)) for name in learnt.profile.tau)])
    print_result(
        f"{'chain':<{width}} {'τ':>8} {'accepted':>9} {'rejected':>9}   between", head=True
    )
    for name, tau in learnt.profile.tau.items():
        r = learnt.reasons[name]
        between = "" if math.isnan(r.low) else f"   {r.low:.2f}–{r.high:.2f}°"
        own = "   its own" if name in learnt.apart else ""
        print_result(
            f"{terminal_text(name):<{width}} {math.degrees(tau):>7.2f}° {r.accepted:>9d} "
            f"{r.rejected:>9d}{between}{own}"
        )
    for sentence in sentences:
        print_result(sentence)
    return 0


def _learnt_to_json(learnt: LearnedProfile, name: str) -> dict[str, Any]:
    reasons = learnt.reasons[name]
    low, high = (None if math.isnan(x) else x for x in (reasons.low, reasons.high))
    return {
        "chain": name,
        "tau_deg": math.degrees(learnt.profile.tau[name]),
        "accepted": reasons.accepted,
        "rejected": reasons.rejected,
        "tau_low_deg": low,
        "tau_high_deg": high,
        "own": name in learnt.apart,
    }
