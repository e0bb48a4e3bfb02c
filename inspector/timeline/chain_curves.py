"""The curves of one chain: what each plot draws, its range, and its title's numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from inspector.language import tr
from inspector.session.document import Document
from inspector.timeline.curve_values import centre_of, degrees_about, unreliable_spans
from inspector.timeline.curves import NOTHING, SAME, Curves, in_degrees, number, widened
from inspector.timeline.pane import Pane
from twistcore.analysis.correction import Angles
from twistcore.skeleton.rotation import wrap

_ANGLES = (("p", "theta_p"), ("c", "theta_c"))


class ChainCurves(Curves):
    """Computes the curves of the document's selected chain and hands them to the plots."""

    panes: Mapping[str, str] = {
        "theta": "θ (°)",
        "delta": "Δθ (°)",
        "strength": tr("strength (°)"),
        "other": tr("strength (°)"),
        "offset": tr("offset (°)"),
    }
    unreliable_words = tr("azimuth unreliable")
    unreliable_hint = tr(
        "Limb nearly straight: the azimuth θc, and so the strength, is unreliable here."
    )

    def __init__(self, document: Document) -> None:
        super().__init__(document)
        assert document.data is not None
        self._chain = document.find_chain(document.chain)
        self._before = document.data.signals[self._chain.name]
        self.unreliable = unreliable_spans(self._before.azimuth_reliability)
        self._method = document.method
        self._centres = {k: centre_of(getattr(self._before, name)) for k, name in _ANGLES}
        self._after: Angles | None = None

    def show_clip(self, panes: Mapping[str, Pane]) -> None:
        """The curves that no decision changes, and the ranges."""
        panes["strength"].set_curve("strength", self.strength)
        panes["strength"].set_curve("after", NOTHING)
        m = np.degrees(self._before.strength)
        own = self._method == "paper"
        panes["strength"].set_curve("m", np.full_like(m, np.nan) if own else m)
        for k, name in _ANGLES:
            y, _ = degrees_about(getattr(self._before, name), self._centres[k])
            self.grow(panes["theta"], y)
            y = np.degrees(getattr(self._before, f"d{name}"))
            self.grow(panes["delta"], y)
            self.grow(panes["delta"], -y)

    def show_review(self, panes: Mapping[str, Pane]) -> None:
        """The curves after correction by the review's intervals, and the offset."""
        self._after = after = self.document.corrected.angles(self._chain)
        for k, name in _ANGLES:
            was, now = getattr(self._before, name), getattr(after, name)
            y, seams = degrees_about(now, self._centres[k])
            panes["theta"].set_curve(f"{k}_after", y, seams)
            self.grow(panes["theta"], y)
            # The clip as it is, only where it differs: two lines on each other would mix colours.
            apart = widened(np.abs(wrap(was - now)) > SAME)
            y, seams = degrees_about(np.where(apart, was, np.nan), self._centres[k])
            panes["theta"].set_curve(f"{k}_before", y, seams)
            was, now = getattr(self._before, f"d{name}"), getattr(after, f"d{name}")
            panes["delta"].set_curve(f"{k}_after", np.degrees(now))
            apart = widened(np.abs(was - now) > SAME)
            panes["delta"].set_curve(f"{k}_before", np.degrees(np.where(apart, was, np.nan)))
        self.show_offset(panes["offset"])

    def completed(self, frame: int, values: Mapping[str, float]) -> Mapping[str, float]:
        """With θc, which is the sum of its changes: those of the clip up to the frame before."""
        if "dtheta_c" not in values:
            return values
        sum_before = float(self._before.theta_c[frame] - self._before.dtheta_c[frame])
        return {**values, "theta_c": float(wrap(sum_before + values["dtheta_c"]))}

    def height(self, key: str, name: str, angle: float) -> float:
        """Beside its curve: of θ in the turn that the curve is in."""
        if key != "theta":
            return super().height(key, name, angle)
        y, _ = degrees_about(np.array([angle]), self._centres[name[-1]])
        return float(y[0])

    def titles(self, frame: int) -> dict[str, list[tuple[str, str]]]:
        """Words and the numbers at a frame, as (text, colour role), by plot."""
        out = {}
        after = self._after
        for key, words, prefix in (
            ("theta", tr("Twist"), ""),
            ("delta", tr("Per frame"), "d"),
        ):
            title = [(f"{words} ", "soft")]
            for k, name in _ANGLES:
                symbol = ("Δ" if prefix else "") + "θ" + k + (" ╌" if k == "c" else "")
                title.append((symbol, "text"))
                turned = prefix + name
                title.append((number(getattr(self._before, turned), frame), "before"))
                if after is not None:
                    title.append((number(getattr(after, turned), frame), "after"))
                title.append(("   ", "soft"))
            if key == "theta":
                title += [(f"{tr('━ before')} ", "before"), (tr("━ after"), "after")]
            else:
                title.append((tr("√ scale"), "soft"))
            out[key] = title
        own = in_degrees(self.strength[frame])
        if self._method == "paper":
            strength = [(f"{tr('Strength')} ", "soft"), ("m", "text"), (own, "before")]
        else:
            m = in_degrees(float(np.degrees(self._before.strength[frame])))
            strength = [
                (f"{tr('Strength')} ", "soft"),
                (own, "before"),
                ("   " + tr("paper's m ╌"), "soft"),
                (m, "soft"),
            ]
        out["strength"] = [*strength, (f"   {tr('√ scale')}", "soft")]
        out["offset"] = self.offset_title(frame)
        return out
