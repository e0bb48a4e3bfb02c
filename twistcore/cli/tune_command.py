"""`twistcore tune`: τ per joint."""

from __future__ import annotations

import argparse
import sys
from functools import partial
from pathlib import Path

from twistcore.cli.output import refuse_overwrite, tell_problems
from twistcore.errors import TwistError
from twistcore.processes import each, reason
from twistcore.rig import AS_FOUND, read_rig
from twistcore.tuning import TauCurve, clip_curves, tuned, write_profile


def tune(arguments: argparse.Namespace) -> int:
    """Write a profile of τ per joint from a clip or all clips of a folder."""
    source: Path = arguments.source
    paths = sorted(source.glob("*.bvh")) if source.is_dir() else [source]
    if not paths:
        raise TwistError(f"{source}: expected a BVH or a folder with some")
    refuse_overwrite([arguments.output], [*paths, *([arguments.rig] if arguments.rig else [])])
    rig = read_rig(arguments.rig) if arguments.rig else AS_FOUND
    work = partial(clip_curves, method=arguments.method, seeds=arguments.seeds, rig=rig)
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
    profile = {name: tuned(curve) for name, curve in curves.items()}
    write_profile(arguments.output, profile, source.name, arguments.method)
    for name, t in profile.items():
        print(
            f"{name:<20} τ {t.tau:6.2f}°   noise {t.noise:6.3f}°   FSR {t.fsr:6.2f} %   "
            f"{t.alarms_per_minute:.2f} false alarms a minute"
        )
    return code
