"""Draw the curves of a chain or limb as short SVG paths, to keep pages with many curves small.

A plot has columns of pixels, and each column covers several frames. For each column, a path has one
or two points: the lowest and the highest value of these frames, so that a jump in a single frame
remains visible. In a path, x is the column, and y is 0 at the top and HEIGHT at the bottom. The
page scales both.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis.clip_analysis import ClipAnalysis
from twistcore.analysis.correction.corrected import Corrected
from twistcore.detection import Interval
from twistcore.review.model import Decision, Judged, Span
from twistcore.skeleton.chain import Chain
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import Array, wrap
from twistcore.work.frozen import dataclass

HEIGHT = 100
MOST_PANELS = 8  # maximum number of chains that are drawn for a clip
_MOST_COLUMNS = 480
_MOST_BYTES = 46_000  # for all curves of a clip, approximately
_BYTES = 9.0  # usual number of bytes for one column of a curve
_ROWS = 3
_SAME = np.radians(0.05)  # curves that differ by less are drawn as one
_AROUND = 0.5  # seconds before and after an enlarged interval


@dataclass(frozen=True)
class CurvePath:
    """An SVG path and its style.

    Attributes
    ----------
    look
        The style: 'same', 'before', 'after' or 'strength'.
    path
        The path's commands.
    """

    look: str
    path: str


@dataclass(frozen=True)
class CurveRow:
    """The plot of one quantity.

    Attributes
    ----------
    symbol, meaning
        Symbol and name of the quantity.
    low, high
        Values at the lower and at the upper edge, in degrees.
    lines
        The curves.
    tau
        The y coordinate of the threshold, from 0 at the top to HEIGHT, or None without a threshold.
    """

    symbol: str
    meaning: str
    low: float
    high: float
    lines: tuple[CurvePath, ...]
    tau: float | None = None


@dataclass(frozen=True)
class Band:
    """An interval, drawn as a vertical band in a panel.

    Attributes
    ----------
    x, width
        First column and width in columns.
    verdict
        The verdict on the interval.
    text
        The interval's frames, offset and verdict.
    """

    x: float
    width: float
    verdict: str
    text: str


@dataclass(frozen=True)
class Panel:
    """The plots of one chain over the same frames.

    Attributes
    ----------
    chain, label
        Name and displayed name of the chain.
    start, stop
        The frames [start, stop).
    columns
        Number of columns of pixels.
    rows
        The plots.
    bands
        The intervals.
    tau_deg
        The threshold in degrees.
    """

    chain: str
    label: str
    start: int
    stop: int
    columns: int
    rows: tuple[CurveRow, ...]
    bands: tuple[Band, ...]
    tau_deg: float


class ClipCurves:
    """The curves of a clip under review, in a form for drawing.

    Parameters
    ----------
    analysis
        The analysis of the clip.
    method
        The detector whose strength is drawn.
    tau
        τ in radians, keyed by the name of the chain or limb.
    judged
        The intervals under review.
    verdict
        A function that returns the text of the verdict on an interval.
    """

    def __init__(
        self,
        analysis: ClipAnalysis,
        method: str,
        tau: Mapping[str, float],
        judged: Sequence[Judged],
        verdict: Callable[[Judged], str] = lambda judged: judged.verdict,
    ) -> None:
        self._verdict = verdict
        self._analysis, self._method, self._tau = analysis, method, tau
        self._by_chain: dict[str, list[Judged]] = {}
        for one in judged:
            self._by_chain.setdefault(one.interval.chain, []).append(one)
        # Curves are unwrapped along the angles of the corrected motion, which seldom jump by 180°.
        self._expected = Corrected(analysis)
        self._expected.take(j.interval for j in judged if _is_expected(j))

    def panels(self, corrected: Corrected) -> tuple[tuple[Panel, ...], int]:
        """Return the panels of the worst chains, worst first, and the number of chains left out.

        Chains without intervals have no panel. `corrected` computes the angles after the
        correction.
        """
        every = self._analysis.chains_and_limbs
        known = [c for c in every if c.name in self._by_chain and c.name in self._tau]
        known.sort(key=lambda c: -sum(map(interval_severity, self._by_chain[c.name])))
        worst, frames = known[:MOST_PANELS], self._analysis.motion.frames
        share = _MOST_BYTES / (_BYTES * _ROWS * max(len(worst), 1))
        columns = max(1, min(_MOST_COLUMNS, int(share), frames))
        drawn = []
        for chain in worst:
            strength = np.degrees(self._analysis.detector(self._method).strength(chain.name))
            symbol, what = (
                ("Δφ", "jump of the swivel") if isinstance(chain, Limb) else ("m(t)", "strength")
            )
            limit = float(np.degrees(self._tau[chain.name]))
            rows = [
                _angle_row(symbol, meaning, before, after, columns)
                for symbol, meaning, before, after in self._angles(corrected, chain)
            ]
            rows.append(_strength_row(symbol, what, strength, limit, columns))
            own = self._by_chain[chain.name]
            drawn.append(self._panel(chain, (0, frames), columns, rows, own))
        return tuple(drawn), len(known) - len(worst)

    def near(self, corrected: Corrected, judged: Judged) -> Panel | None:
        """Return a panel that enlarges an interval, or None if the clip does not have its chain.

        `corrected` computes the angles after the correction.
        """
        interval, motion = judged.interval, self._analysis.motion
        every = self._analysis.chains_and_limbs
        chain = next((c for c in every if c.name == interval.chain), None)
        if chain is None or chain.name not in self._tau:
            return None
        span = frames_around(interval, motion)
        columns = max(1, min(_MOST_COLUMNS // 3, span[1] - span[0]))
        symbol, meaning, *angles = self._angles(corrected, chain)[0]
        before, after = (angle[slice(*span)] for angle in angles)
        row = _angle_row(symbol, meaning, before, after, columns)
        return self._panel(chain, span, columns, [row], [judged])

    def _panel(
        self,
        chain: Chain,
        span: tuple[int, int],
        columns: int,
        rows: Sequence[CurveRow],
        judged: Iterable[Judged],
    ) -> Panel:
        scale = columns / (span[1] - span[0])
        bands = tuple(
            Band(
                round((j.interval.start - span[0]) * scale, 1),
                round(max(j.interval.frames * scale, 1.5), 1),
                self._verdict(j),
                f"frames {j.interval.start}–{j.interval.stop}, "
                f"{j.reported.angle_text(1)}, {self._verdict(j)}",
            )
            for j in judged
        )
        tau = float(np.degrees(self._tau[chain.name]))
        return Panel(chain.name, chain.label, *span, columns, tuple(rows), bands, tau)

    def _angles(self, corrected: Corrected, chain: Chain) -> list[tuple[str, str, Array, Array]]:
        """Return the symbol, the name, and the angles before and after the correction of each row.

        The angles are unwrapped and in radians, shape (frames,).
        """
        expected = self._expected
        if isinstance(chain, Limb):
            was = self._analysis.flips.limbs[chain.name].swivel.angle
            now = [c.swivel(chain) for c in (corrected, expected)]
            return [("φ", "swivel of the limb", *_unwrapped(was, *now))]
        signals = self._analysis.signals[chain.name]
        after, sound = (c.angles(chain) for c in (corrected, expected))
        return [
            (
                "θp",
                "twist of the parent",
                *_unwrapped(signals.theta_p, after.theta_p, sound.theta_p),
            ),
            (
                "θc",
                "azimuth of the child",
                *_unwrapped(signals.theta_c, after.theta_c, sound.theta_c),
            ),
        ]


def frames_around(interval: Interval, motion: Motion) -> Span:
    """Return the span [start, stop) of an interval with half a second before and after it."""
    around = max(3, round(_AROUND * motion.fps))
    return max(0, interval.start - around), min(motion.frames, interval.stop + around)


def _unwrapped(before: Array, after: Array, expected: Array) -> tuple[Array, Array]:
    """Unwrap the angles `before` and `after` so that they stay near a third angle, `expected`.

    The results differ from the unwrapped `expected` by at most half a turn.
    """
    way = np.unwrap(expected)
    return way + wrap(before - expected), way + wrap(after - expected)


def interval_severity(judged: Judged) -> float:
    """Return the severity of an interval, in degrees × frames.

    For an interval without an offset, it is the angle in degrees.
    """
    interval = judged.interval
    if not judged.counts:
        return float(abs(np.degrees(interval.residual)))
    return float(np.degrees(np.abs(interval.offset)).sum())


def _is_expected(judged: Judged) -> bool:
    """Return True if an interval is corrected in the expected motion.

    Curves are unwrapped along the angles of this motion.
    """
    return judged.counts and judged.decision != Decision.REJECTED


def _angle_row(symbol: str, meaning: str, before: Array, after: Array, columns: int) -> CurveRow:
    """Return a row with one curve, or with two curves where the correction changes the angle."""
    every = np.degrees(np.concatenate([before, after]))
    low, high = _range(float(every.min()), float(every.max()))
    edges = _edges(len(before), columns)
    differs = np.logical_or.reduceat(np.abs(after - before) > _SAME, edges)
    wide = differs.copy()  # extended by a column on each side, to connect the lines
    wide[1:] |= differs[:-1]
    wide[:-1] |= differs[1:]
    plain = _levels(np.degrees(before), low, high)
    other = _levels(np.degrees(after), low, high)
    lines = [
        CurvePath("same", _path(plain, edges, ~differs)),
        CurvePath("before", _path(plain, edges, wide)),
        CurvePath("after", _path(other, edges, wide)),
    ]
    return CurveRow(symbol, meaning, low, high, tuple(line for line in lines if line.path))


def _strength_row(symbol: str, meaning: str, values: Array, tau: float, columns: int) -> CurveRow:
    """Return a row with the strength on a square-root scale, which shows both τ and high peaks."""
    _, high = _range(0.0, max(float(values.max(initial=0.0)), 1.4 * tau))
    roots = _levels(np.sqrt(np.abs(values)), 0.0, float(np.sqrt(high)))
    path = _path(roots, _edges(len(values), columns), np.ones(columns, np.bool_))
    level = round(HEIGHT * (1.0 - float(np.sqrt(tau / high))), 1)
    return CurveRow(symbol, meaning, 0.0, high, (CurvePath("strength", path),), level)


def _range(low: float, high: float) -> tuple[float, float]:
    """Return a range in whole degrees around `low`…`high` with a margin of at least 1°."""
    air = max(0.06 * (high - low), 1.0)
    return float(np.floor(low - air * (low != 0.0))), float(np.ceil(high + air))


def _edges(count: int, columns: int) -> NDArray[np.intp]:
    """Return the index of the first frame in each column of the plot, shape (columns,)."""
    return (np.arange(columns) * count // columns).astype(np.intp)


def _levels(values: Array, low: float, high: float) -> NDArray[np.int64]:
    """Convert degrees to y coordinates. `low` and `high` are the values at the plot's edges."""
    levels: NDArray[np.int64] = np.rint(HEIGHT * (high - values) / (high - low)).astype(np.int64)
    return levels


def _path(
    levels: NDArray[np.int64], edges: NDArray[np.intp], shown: NDArray[np.bool_]
) -> str:  # fmt: skip
    """Return an SVG path through the lowest and highest values of the columns in a mask.

    `levels` are y coordinates, `edges` has the first frame of each column, and `shown` is the mask.
    The path is '' if no column is shown.
    """
    least, most = np.minimum.reduceat(levels, edges), np.maximum.reduceat(levels, edges)
    first = levels[edges]
    parts: list[str] = []
    x = y = flat = 0
    fresh = True
    for column in np.flatnonzero(shown).tolist():
        rising = first[column] - least[column] <= most[column] - first[column]
        ends = int(least[column]), int(most[column])
        near_end, far_end = ends if rising else ends[::-1]
        if fresh or column != x + 1:
            if flat:
                parts.append(f"h{flat}")
            parts.append(f"M{column} {near_end}")
        elif near_end == y == far_end:
            flat += 1
            x = column
            continue
        else:
            if flat:
                parts.append(f"h{flat}")
            parts.append(f"l1{near_end - y:+d}" if near_end != y else "h1")
        flat = 0
        if far_end != near_end:
            parts.append(f"v{far_end - near_end}")
        x, y, fresh = column, far_end, False
    if flat:
        parts.append(f"h{flat}")
    return "".join(parts)
