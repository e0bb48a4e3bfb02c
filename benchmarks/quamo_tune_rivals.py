"""Tune the settings of QuaMo's rivals: python -m benchmarks.quamo_tune_rivals FOLDER [--seeds N].

Settings are chosen from a grid on subjects that are not used for any table (02, 08, 12), with new
noise of both levels, first for rotations and then for the root's position. The rule is:

- Consider only settings with an MPJPE (for the root: GRE) no larger than ours at each level. If
  there is none, consider the setting that exceeds ours least.
- Choose the setting with the smallest Accel (for the root: G-Accel), as the mean over both levels.
- Among settings with an Accel within 1 % of the smallest, choose the one with the smallest MPJPE
  (for the root: GRE).

All metrics are ratios output / input. Causal rivals are compared with our hand-tuned gains, and
rivals that use the whole file with our tracking in both directions.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path

import numpy as np

from twistcore.quamo import HandGains, track, track_both_ways
from twistcore.quamo.state_space import NETWORK_DT
from twistcore.skeleton.rotation import Array
from twistcore.study.quamo.noise import LEVELS
from twistcore.study.quamo.pose_errors import second_difference
from twistcore.study.quamo.rivals import RIVALS, Rival, Setting
from twistcore.study.quamo.sequences import HELD_OUT, Sequence24, read_cmu_bvh_sequence_folder
from twistcore.study.quamo.tables import CONDITIONS, markdown_table, noisy_clip

FIRST_SEED = 300  # not used by any table or training
EQUAL = 1.01  # settings with an Accel up to this multiple of the smallest count as equal
CUTOFFS = tuple(np.arange(2.0, 8.01, 0.5).tolist())
EURO = (
    (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0),
    (0.0, 0.5, 1.0, 2.0, 3.0, 4.0, 6.0),
    (1.0, 2.0, 4.0, 8.0),
)
GRIDS: Mapping[str, tuple[Setting, ...]] = {
    "One-Euro": tuple(product(*EURO)),
    "Butterworth": tuple(product((1.0, 2.0, 3.0), (*CUTOFFS, 9.0, 10.0, 11.0, 12.0))),
    "Butterworth, file": tuple(product((1.0, 2.0, 3.0), CUTOFFS)),
    "Savitzky-Golay, file": tuple(
        (float(n), float(d)) for n in range(5, 22, 2) for d in (2, 3, 4, 5) if d < n
    ),
    "spline, file": tuple((c,) for c in CUTOFFS),
}
METRICS = ("MPJPE", "Accel", "GRE", "G-Accel")
Poses = tuple[Array, Array]


class Trials:
    """The training clips with noise of both levels, on which many settings are tried.

    Attributes
    ----------
    drawn
        For each clip, the noisy rotations, shape (frames, levels, seeds, 24, 4), and root
        positions, shape (frames, levels, seeds, 3).
    """

    def __init__(self, clips: Sequence[Sequence24], seeds: int) -> None:
        self._clips = [c for c in clips if c.subject not in HELD_OUT]
        self.drawn = [_drawn(clip, seeds) for clip in self._clips]
        self._input = self._sums(self.drawn)

    def ratios(self, found: Sequence[Poses]) -> Array:
        """Return the ratios output / input of the metrics over all clips, shape (levels, METRICS).

        Longer clips have more weight.
        """
        return self._sums(found) / self._input

    def _sums(self, found: Sequence[Poses]) -> Array:
        sums: Array = np.zeros((2, len(METRICS)))
        for clip, (q, r) in zip(self._clips, found, strict=True):
            truth = clip.places_mm(clip.q, clip.r)[:, None, None]
            places = clip.places_mm(q, r)
            here, there = (p[..., 1:, :] - p[..., :1, :] for p in (places, truth))
            errors = (
                here - there,
                second_difference(here - there),
                places[..., :1, :] - truth[..., :1, :],
                second_difference(places - truth),
            )
            sizes = [np.linalg.norm(e, axis=-1).mean(axis=(0, 2, 3)) for e in errors]
            sums += len(q) * np.stack(sizes, axis=1)
        return sums


def _drawn(clip: Sequence24, seeds: int) -> Poses:
    conditions = [c for c in CONDITIONS if not c.systematic]
    each = [[noisy_clip(clip, c.noise, FIRST_SEED + k) for k in range(seeds)] for c in conditions]
    return (
        np.stack([np.stack([q for q, _ in level], axis=1) for level in each], axis=1),
        np.stack([np.stack([r for _, r in level], axis=1) for level in each], axis=1),
    )


def ours(q_hat: Array, r_hat: Array, causal: bool) -> Poses:
    """Return the result of our tracker, with which a rival is compared.

    `q_hat` and `r_hat` are the noisy rotations and root positions.
    """
    way = track if causal else track_both_ways
    found = way(q_hat, r_hat, NETWORK_DT, HandGains())
    return found.q, found.r


def best(ratios: Mapping[Setting, Array], bound: Array, least: str, bounded: str) -> Setting:
    """Return the setting chosen by the rule in the module's docstring.

    Parameters
    ----------
    ratios
        The ratios of each setting, shape (levels, METRICS).
    bound
        Our ratios, with the same shape.
    least
        The metric to minimise.
    bounded
        The metric that must not be larger than ours.
    """
    at, kept = METRICS.index(least), METRICS.index(bounded)
    short = {s: float(np.maximum(r - bound, 0.0)[:, kept].sum()) for s, r in ratios.items()}
    able = [s for s in ratios if short[s] == min(short.values())]
    rough = {s: float(ratios[s][:, at].mean()) for s in able}
    equal = [s for s in able if rough[s] <= EQUAL * min(rough.values())]
    return min(equal, key=lambda s: float(ratios[s][:, kept].mean()))


def tuned(rival: Rival, trials: Trials, bound: Array) -> tuple[Setting, Setting, Array]:
    """Return a rival's settings for rotations and for positions, and the ratios with both.

    `bound` are our ratios.
    """

    def ratios(turned: Sequence[Array], moved: Sequence[Array]) -> Array:
        return trials.ratios(list(zip(turned, moved, strict=True)))

    def rotations(setting: Setting) -> list[Array]:
        return [rival.rotations(q_hat, NETWORK_DT, setting) for q_hat, _ in trials.drawn]

    def places(setting: Setting) -> list[Array]:
        return [rival.places(r_hat, NETWORK_DT, setting) for _, r_hat in trials.drawn]

    grid, given = GRIDS[rival.name], [r_hat for _, r_hat in trials.drawn]
    turning = best({s: ratios(rotations(s), given) for s in grid}, bound, "Accel", "MPJPE")
    turned = rotations(turning)
    found = {s: ratios(turned, places(s)) for s in grid}
    moving = best(found, bound, "G-Accel", "GRE")
    return turning, moving, found[moving]


def main() -> None:
    """Print the chosen settings of every rival, and its ratios at both noise levels."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seeds", type=int, default=8)
    arguments = parser.parse_args()
    trials = Trials(read_cmu_bvh_sequence_folder(arguments.folder)[0], arguments.seeds)
    rows: list[tuple[str, ...]] = []

    def add(name: str, turning: object, moving: object, ratios: Array) -> None:
        cells = [f"{v:.3f}" for v in ratios.ravel()]
        rows.append((name, str(turning), str(moving), *cells))

    bounds = {}
    for causal, name in ((True, "hand gains"), (False, "hand gains, both ways")):
        found = [ours(q_hat, r_hat, causal) for q_hat, r_hat in trials.drawn]
        bounds[causal] = trials.ratios(found)
        add(name, "", "", bounds[causal])
    for rival in RIVALS:
        add(rival.name, *tuned(rival, trials, bounds[rival.causal]))
    head = ("", "rotations", "root", *(f"{level}: {m}" for level in LEVELS for m in METRICS))
    print(markdown_table(head, rows))


if __name__ == "__main__":
    main()
