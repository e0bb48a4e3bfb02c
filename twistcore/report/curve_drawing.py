"""Curves of a chain or limb for a page: paths so small that a page of many stays small.

A path has one point or two for a column of the picture, the lowest and the highest value that the
column's frames have, so that no jump of a single frame is lost. x counts columns, y goes down from
0 to HEIGHT; the page stretches both.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twistcore.analysis import ClipAnalysis
from twistcore.chain import Chain
from twistcore.limb import Limb
from twistcore.refinement import Corrected
from twistcore.review.model import Judged
from twistcore.rotation import Array, wrap

HEIGHT = 100
MOST_PANELS = 8  # chains drawn of a clip, worst first
_MOST_COLUMNS = 480
_MOST_BYTES = 46_000  # of all curves of a clip, about
_BYTES = 9.0  # of a column of a curve
_ROWS = 3
_SAME = np.radians(0.05)  # curves that differ by less are one
_AROUND = 0.5  # seconds before and behind an interval that is drawn large


@dataclass(frozen=True)
class Line:
    """One path; look: 'same', 'before', 'after' or 'strength'."""

    look: str
    path: str


@dataclass(frozen=True)
class Row:
    """One quantity over time: its symbol, the values at the bottom and the top, degrees.

    tau: where the threshold is, 0 at the top to HEIGHT, None where the quantity has none.
    """

    symbol: str
    meaning: str
    low: float
    high: float
    lines: tuple[Line, ...]
    tau: float | None = None


@dataclass(frozen=True)
class Band:
    """An interval in a panel: columns from x on, so wide, and its decision."""

    x: float
    width: float
    verdict: str
    text: str


@dataclass(frozen=True)
class Panel:
    """The curves of one chain over frames [start, stop)."""

    chain: str
    label: str
    start: int
    stop: int
    columns: int
    rows: tuple[Row, ...]
    bands: tuple[Band, ...]
    tau_deg: float


def panels(
    analysis: ClipAnalysis, corrected: Corrected, method: str, tau: Mapping[str, float],
    judged: Sequence[Judged],
) -> tuple[tuple[Panel, ...], int]:  # fmt: skip
    """Panels of the chains and limbs that have intervals, worst first, and how many were left out.

    corrected: has taken what is applied; tau: radians by name.
    """
    by_chain: dict[str, list[Judged]] = {}
    for one in judged:
        by_chain.setdefault(one.interval.chain, []).append(one)
    known = [c for c in analysis.chains_and_limbs if c.name in by_chain and c.name in tau]
    worst = sorted(known, key=lambda c: -sum(weight(j) for j in by_chain[c.name]))[:MOST_PANELS]
    frames = analysis.motion.frames
    share = _MOST_BYTES / (_BYTES * _ROWS * max(len(worst), 1))
    columns = max(1, min(_MOST_COLUMNS, int(share), frames))
    drawn = [
        _panel(analysis, corrected, method, tau, chain, by_chain[chain.name], (0, frames), columns)
        for chain in worst
    ]
    return tuple(drawn), len(known) - len(worst)


def near(
    analysis: ClipAnalysis, corrected: Corrected, method: str, tau: Mapping[str, float],
    judged: Judged,
) -> Panel | None:  # fmt: skip
    """One interval and what is around it, drawn large; None where its chain is not there."""
    chain = next((c for c in analysis.chains_and_limbs if c.name == judged.interval.chain), None)
    if chain is None or chain.name not in tau:
        return None
    around = max(3, round(_AROUND * analysis.motion.fps))
    start = max(0, judged.interval.start - around)
    stop = min(analysis.motion.frames, judged.interval.stop + around)
    columns = max(1, min(_MOST_COLUMNS // 3, stop - start))
    panel = _panel(analysis, corrected, method, tau, chain, [judged], (start, stop), columns)
    return Panel(**{**vars(panel), "rows": panel.rows[:1]})


def weight(judged: Judged) -> float:
    """How bad an interval is: degrees times frames; a lone jump by its turn."""
    interval = judged.interval
    if not interval.repairable:
        return float(abs(np.degrees(interval.residual)))
    return float(np.degrees(np.abs(interval.offset)).sum())


def _panel(
    analysis: ClipAnalysis, corrected: Corrected, method: str, tau: Mapping[str, float],
    chain: Chain, judged: Iterable[Judged], span: tuple[int, int], columns: int,
) -> Panel:  # fmt: skip
    start, stop = span
    strength = np.degrees(analysis.detector(method).strength(chain.name))[start:stop]
    limit = float(np.degrees(tau[chain.name]))
    rows = []
    for symbol, meaning, before, after in _angles(analysis, corrected, chain):
        rows.append(_two(symbol, meaning, before[start:stop], after[start:stop], columns))
    m = (
        ("Δφ", "jump of the swivel on a square-root scale")
        if isinstance(chain, Limb)
        else ("m(t)", "strength on a square-root scale")
    )
    rows.append(_strength(*m, strength, limit, columns))
    scale = columns / (stop - start)
    bands = tuple(
        Band(
            round((j.interval.start - start) * scale, 1),
            round(max(j.interval.frames * scale, 1.5), 1),
            j.verdict,
            f"frames {j.interval.start}–{j.interval.stop}, "
            f"{np.degrees(j.interval.shown):+.1f}°, {j.verdict}",
        )
        for j in judged
    )
    return Panel(chain.name, chain.label, start, stop, columns, tuple(rows), bands, limit)


def _angles(
    analysis: ClipAnalysis, corrected: Corrected, chain: Chain
) -> list[tuple[str, str, Array, Array]]:
    """Symbol, meaning, and values before and after, radians, without turns at ±180°."""
    if isinstance(chain, Limb):
        swivel = analysis.flips.limbs[chain.name].swivel.angle
        pairs = [("φ", "swivel of the limb", swivel, corrected.swivel(chain))]
    else:
        was, now = analysis.signals[chain.name], corrected.angles(chain)
        pairs = [
            ("θp", "twist of the parent", was.theta_p, now.theta_p),
            ("θc", "azimuth of the child", was.theta_c, now.theta_c),
        ]
    out = []
    for symbol, meaning, before, after in pairs:
        whole = np.unwrap(before)
        out.append((symbol, meaning, whole, whole + wrap(after - before)))
    return out


def _two(symbol: str, meaning: str, before: Array, after: Array, columns: int) -> Row:
    """A row of one curve where nothing changes, and of two where something does."""
    every = np.degrees(np.concatenate([before, after]))
    low, high = _range(float(every.min()), float(every.max()))
    edges = _edges(len(before), columns)
    differs = np.logical_or.reduceat(np.abs(after - before) > _SAME, edges)
    wide = differs.copy()  # one column more on either side: the lines meet
    wide[1:] |= differs[:-1]
    wide[:-1] |= differs[1:]
    plain = _levels(np.degrees(before), low, high)
    other = _levels(np.degrees(after), low, high)
    lines = [
        Line("same", _path(plain, edges, ~differs)),
        Line("before", _path(plain, edges, wide)),
        Line("after", _path(other, edges, wide)),
    ]
    return Row(symbol, meaning, low, high, tuple(line for line in lines if line.path))


def _strength(symbol: str, meaning: str, values: Array, tau: float, columns: int) -> Row:
    """On a square-root scale: τ is seen beside peaks a hundred times as high."""
    _, high = _range(0.0, max(float(values.max(initial=0.0)), 1.4 * tau))
    roots = _levels(np.sqrt(np.abs(values)), 0.0, float(np.sqrt(high)))
    path = _path(roots, _edges(len(values), columns), np.ones(columns, np.bool_))
    level = round(HEIGHT * (1.0 - float(np.sqrt(tau / high))), 1)
    return Row(symbol, meaning, 0.0, high, (Line("strength", path),), level)


def _range(low: float, high: float) -> tuple[float, float]:
    """A range with some air that is never so small that noise fills it, whole degrees."""
    air = max(0.06 * (high - low), 1.0)
    return float(np.floor(low - air * (low != 0.0))), float(np.ceil(high + air))


def _edges(count: int, columns: int) -> NDArray[np.intp]:
    """Where the frames of each column begin, (columns,)."""
    return (np.arange(columns) * count // columns).astype(np.intp)


def _levels(values: Array, low: float, high: float) -> NDArray[np.int64]:
    """Degrees as y."""
    levels: NDArray[np.int64] = np.rint(HEIGHT * (high - values) / (high - low)).astype(np.int64)
    return levels


def _path(
    levels: NDArray[np.int64], edges: NDArray[np.intp], shown: NDArray[np.bool_]
) -> str:  # fmt: skip
    """A path through the lowest and highest of every column that is shown; '' for none."""
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
