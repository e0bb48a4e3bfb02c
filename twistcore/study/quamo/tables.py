"""Score methods under every noise condition and seed, and write tables and JSON."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from twistcore.skeleton.rotation import Array
from twistcore.study.quamo.noise import LEVELS, Noise, add_pose_noise
from twistcore.study.quamo.pose_errors import METRICS, pose_metrics
from twistcore.study.quamo.sequences import Sequence24
from twistcore.synthesis import clip_random_generator

# A method is a function of a clip and of noisy versions of its poses (frames, versions, 24, 4) and
# root positions (frames, versions, 3), and returns such poses and positions. The clip's subject was
# not used in training.
Method = Callable[[Sequence24, Array, Array], tuple[Array, Array]]

_ORDER = tuple(LEVELS.values())


@dataclass(frozen=True)
class NoiseCondition:
    """The noise condition of a table: an error level, with or without a systematic part."""

    level: str
    systematic: bool

    def __str__(self) -> str:
        return f"{self.level}{' + systematic' if self.systematic else ''}"

    @property
    def noise(self) -> Noise:
        """Return the noise to add."""
        return Noise(LEVELS[self.level], self.systematic)


CONDITIONS = tuple(NoiseCondition(level, s) for level in LEVELS for s in (False, True))


@dataclass(frozen=True, eq=False)
class Scores:
    """The error metrics of methods, averaged over frames.

    Attributes
    ----------
    by_method
        Metrics keyed by method and condition, shape (seeds, len(METRICS)).
    clips
        Names of the clips.
    """

    by_method: Mapping[tuple[str, NoiseCondition], Array]
    clips: tuple[str, ...]

    def mean(self, method: str, condition: NoiseCondition) -> Array:
        """Return a method's metrics, averaged over seeds, in the order of METRICS."""
        mean: Array = self.by_method[method, condition].mean(axis=0)
        return mean

    def ratio(self, method: str, condition: NoiseCondition) -> Array:
        """Return a method's mean metrics, divided by those of the input, in the order of METRICS.

        Where the input's mean is 0, the ratio is 1.
        """
        return _ratio(self.mean(method, condition), self.mean("input", condition))

    def ratios(self, method: str, condition: NoiseCondition, base: str = "input") -> Array:
        """Return the metrics of `method` divided by those of `base`, (seeds, len(METRICS))."""
        return _ratio(self.by_method[method, condition], self.by_method[base, condition])


def _ratio(over: Array, under: Array) -> Array:
    return np.divide(over, under, out=np.ones_like(over), where=under > 0.0)


def score_methods(
    sequences: Sequence[Sequence24],
    methods: Mapping[str, Method],
    seeds: Sequence[int],
    conditions: Sequence[NoiseCondition] = CONDITIONS,
    tell: Callable[[str], None] = lambda _: None,
    *,
    from_truth: bool = False,
) -> Scores:
    """Run every method on every clip, noise condition and seed. All methods get the same noise.

    If `from_truth` is True, the input is shifted so that its root begins at the true position [Le26
    §4.2].
    """
    # A method processes all conditions and seeds of a clip at once, which takes far fewer steps.
    draws = [(condition, k) for condition in conditions for k in range(len(seeds))]
    table = {
        (name, c): np.zeros((len(seeds), len(METRICS)))
        for c in conditions
        for name in ("input", *methods)
    }
    total = sum(len(s.q) for s in sequences)
    for sequence in sequences:
        drawn = [noisy_clip(sequence, c.noise, seeds[k]) for c, k in draws]
        q_hat, r_hat = (np.stack(x, axis=1) for x in zip(*drawn, strict=True))
        if from_truth:
            r_hat = r_hat - r_hat[:1] + sequence.r[0]
        truth = sequence.places_mm(sequence.q, sequence.r)
        for name in ("input", *methods):
            q, r = (q_hat, r_hat) if name == "input" else methods[name](sequence, q_hat, r_hat)
            places = sequence.places_mm(q, r)
            for d, (condition, k) in enumerate(draws):
                found = np.array(pose_metrics(places[:, d], truth).values())
                table[name, condition][k] += len(sequence.q) / total * found
        tell(f"{sequence.name}: {len(sequence.q)} frames")
    return Scores(table, tuple(s.name for s in sequences))


def noisy_clip(sequence: Sequence24, noise: Noise, seed: int) -> tuple[Array, Array]:
    """Return a clip's poses and root positions with noise.

    The noise depends only on the seed, the clip's name and the kind of noise.
    """
    rng = clip_random_generator(
        seed, sequence.name, _ORDER.index(noise.level), int(noise.systematic)
    )
    return add_pose_noise(sequence.q, sequence.r, noise, rng)


def scores_to_json(scores: Scores) -> dict[str, Any]:
    """Return the means and the values for each seed, by method and condition."""
    return {
        "clips": list(scores.clips),
        "metrics": list(METRICS),
        "rows": [
            {
                "method": method,
                "level": condition.level,
                "systematic": condition.systematic,
                "mean": np.round(values.mean(axis=0), 6).tolist(),
                "seeds": np.round(values, 6).tolist(),
            }
            for (method, condition), values in scores.by_method.items()
        ],
    }


def scores_to_markdown(scores: Scores, methods: Sequence[str], condition: NoiseCondition) -> str:
    """Return a Markdown table for a noise condition: metrics, and their ratios to the input."""
    rows = []
    for method in methods:
        mean, ratio = scores.mean(method, condition), scores.ratio(method, condition)
        shown = [f"{m:.1f}" for m in mean]
        if method != "input":
            shown = [f"{m} ({r:.2f})" for m, r in zip(shown, ratio, strict=True)]
        rows.append((method, *shown))
    return markdown_table((f"noise {condition}", *METRICS), rows)


def error_ratios_to_markdown(
    title: str, scores: Scores, methods: Sequence[str], condition: NoiseCondition
) -> str:
    """Return a Markdown table for a noise condition: only the ratios to the input."""
    rows = [(m, *(f"{r:.2f}" for r in scores.ratio(m, condition))) for m in methods]
    return markdown_table((title, *METRICS), rows)


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a Markdown table without padding in its cells."""
    lines = [f"| {' | '.join(cells)} |" for cells in (head, *rows)]
    lines.insert(1, f"|{'---|' * len(head)}")
    return "\n".join(lines) + "\n"
