"""The curves of one chain: what each plot draws, its range, and its title's numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from inspector.session.document import Document
from inspector.timeline.curve_values import centre_of, degrees_about
from inspector.timeline.pane import Pane
from twistcore.refinement import Angles
from twistcore.rotation import Array, wrap

_ANGLES = (("p", "theta_p"), ("c", "theta_c"))
_SMALLEST = {"theta": 20.0, "delta": 10.0, "offset": 10.0}  # degrees that a plot spans at least
_SAME = 1e-6  # radians
_HEADROOM = 2.2  # times τ that the strength plot reaches at least


class ChainCurves:
    """Computes the curves of the document's selected chain and hands them to the plots."""

    def __init__(self, document: Document) -> None:
        assert document.data is not None
        data = document.data
        self._document = document
        self._chain = document.find_chain(document.chain)
        self._before = data.signals[self._chain.name]
        self._strength = np.degrees(document.detector.strength(self._chain.name))
        self._peak = float(self._strength.max(initial=0.0))
        self._method = document.method
        self._centres = {k: centre_of(getattr(self._before, name)) for k, name in _ANGLES}
        self._after: Angles | None = None
        self._ranges: dict[str, tuple[float, float]] = {}
        self._reach = (0.0, 1.0)

    def show_clip(self, panes: Mapping[str, Pane]) -> None:
        """The curves that no decision changes, and the ranges."""
        panes["strength"].set_curve("strength", self._strength)
        m = np.degrees(self._before.strength)
        own = self._method == "paper"
        panes["strength"].set_curve("m", np.full_like(m, np.nan) if own else m)
        for k, name in _ANGLES:
            y, _ = degrees_about(getattr(self._before, name), self._centres[k])
            self._grow(panes["theta"], y)
            y = np.degrees(getattr(self._before, f"d{name}"))
            self._grow(panes["delta"], y)
            self._grow(panes["delta"], -y)

    def show_review(self, panes: Mapping[str, Pane]) -> None:
        """The curves after correction by the review's intervals, and the offset."""
        document = self._document
        self._after = after = document.corrected.angles(self._chain)
        for k, name in _ANGLES:
            was, now = getattr(self._before, name), getattr(after, name)
            y, seams = degrees_about(now, self._centres[k])
            panes["theta"].set_curve(f"{k}_after", y, seams)
            self._grow(panes["theta"], y)
            # The clip as it is, only where it differs: two lines on each other would mix colours.
            apart = _widened(np.abs(wrap(was - now)) > _SAME)
            y, seams = degrees_about(np.where(apart, was, np.nan), self._centres[k])
            panes["theta"].set_curve(f"{k}_before", y, seams)
            was, now = getattr(self._before, f"d{name}"), getattr(after, f"d{name}")
            panes["delta"].set_curve(f"{k}_after", np.degrees(now))
            apart = _widened(np.abs(was - now) > _SAME)
            panes["delta"].set_curve(f"{k}_before", np.degrees(np.where(apart, was, np.nan)))
        degrees = np.degrees(document.offset(self._chain.name))
        panes["offset"].set_curve("offset", degrees)
        self._grow(panes["offset"], degrees)

    def fit_tau(self, pane: Pane, degrees: float) -> None:
        """The strength plot reaches from 0 over its peak and well over τ."""
        reach = (0.0, min(max(self._peak, _HEADROOM * degrees, 5.0), max(190.0, self._peak)))
        if reach != self._reach:
            self._reach = reach
            pane.show_values(*reach)

    def titles(self, frame: int) -> dict[str, list[tuple[str, str]]]:
        """Words and the numbers at a frame, as (text, colour role), by plot."""
        out = {}
        after = self._after
        for key, words, prefix in (("theta", "Twist ", ""), ("delta", "Per frame ", "d")):
            title = [(words, "soft")]
            for k, name in _ANGLES:
                symbol = ("Δ" if prefix else "") + "θ" + k + (" ╌" if k == "c" else "")
                title.append((symbol, "text"))
                turned = prefix + name
                title.append((_number(getattr(self._before, turned), frame), "before"))
                if after is not None:
                    title.append((_number(getattr(after, turned), frame), "after"))
                title.append(("   ", "soft"))
            if key == "theta":
                title += [("━ before ", "before"), ("━ after", "after")]
            else:
                title.append(("√ scale", "soft"))
            out[key] = title
        own = _degrees(self._strength[frame])
        if self._method == "paper":
            strength = [("Strength ", "soft"), ("m", "text"), (own, "before")]
        else:
            m = _degrees(float(np.degrees(self._before.strength[frame])))
            strength = [
                ("Strength ", "soft"),
                (own, "before"),
                ("   paper's m ╌", "soft"),
                (m, "soft"),
            ]
        out["strength"] = [*strength, ("   √ scale", "soft")]
        offset = self._document.offset(self._chain.name)
        out["offset"] = [("Offset taken out ", "soft"), (_number(offset, frame), "text")]
        return out

    def _grow(self, pane: Pane, degrees: Array) -> None:
        """Widen a plot's range where a curve leaves it; it never narrows under the hand."""
        seen = degrees[np.isfinite(degrees)]
        low, high = (float(seen.min()), float(seen.max())) if len(seen) else (0.0, 0.0)
        old = self._ranges.get(pane.key)
        if old is None:
            spare = 0.5 * max(0.0, _SMALLEST[pane.key] - (high - low))
            low, high = low - spare, high + spare
        elif low >= old[0] and high <= old[1]:
            return
        else:
            low, high = min(low, old[0]), max(high, old[1])
        self._ranges[pane.key] = (low, high)
        pane.show_values(low, high)


def _widened(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """One frame to either side too, where one line leaves the other."""
    wider = mask.copy()
    wider[1:] |= mask[:-1]
    wider[:-1] |= mask[1:]
    return wider


def _number(angle: Array, frame: int) -> str:
    return _degrees(float(np.degrees(wrap(angle[frame]))))


def _degrees(value: float) -> str:
    return f"{round(value, 1) + 0.0:7.1f}°".replace("-", "−")  # + 0.0: no minus before zero
