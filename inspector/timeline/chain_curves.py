"""The values of a chain's curves before and after correction."""

from __future__ import annotations

from collections.abc import Mapping

from inspector.language import tr
from inspector.session.document import Document
from inspector.timeline.curve_values import circular_mean_angle, unreliable_spans
from inspector.timeline.curves import NOTHING, Curves, Title, format_angle_at_frame
from twistcore.analysis.correction.corrected import Angles
from twistcore.detection import DETECTORS
from twistcore.detection.paper import paper_detector_running_offset
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.rotation import wrap
from twistcore.skeleton.signals import TwistSignals, twist_signals

ANGLES = (("p", "theta_p"), ("c", "theta_c"))


class ChainCurves(Curves):
    """The curves of the chain that is selected in the document.

    Attributes
    ----------
    before, after
        The captured and the corrected angles of the chain.
    centres
        The circular means of θp and θc, in radians, keyed by 'p' and 'c'.
    tracked
        The angles after tracking, or None if the clip is not tracked.
    running
        The function offset(t) of the paper at the chain's τ, in radians. It is empty in an
        exercise, because it would reveal the errors.
    """

    unreliable_words = tr("azimuth unreliable")
    unreliable_hint = tr(
        "The limb is nearly straight here, so the azimuth θc and the strength are unreliable."
    )

    def __init__(self, document: Document) -> None:
        super().__init__(document)
        assert document.data is not None
        self._chain = document.find_chain(document.chain)
        self.before = document.data.signals[self._chain.name]
        self.unreliable = unreliable_spans(self.before.azimuth_reliability)
        self.is_m = DETECTORS.info(document.method).is_m
        self.centres = {k: circular_mean_angle(getattr(self.before, name)) for k, name in ANGLES}
        self.after: Angles | TwistSignals = self.before
        self.running = NOTHING
        self.tracked: TwistSignals | None = None
        self._tracked_motion: Motion | None = None

    def follow_review(self) -> None:
        """Update the values that depend on the review's intervals and τ."""
        self.after = self.document.corrected.angles(self._chain)
        if (motion := self.document.tracked) is not self._tracked_motion:
            self._tracked_motion = motion
            self.tracked = None if motion is None else twist_signals(motion, self._chain)
        tau = self.document.review.state.tau.get(self._chain.name)
        blind = self.document.data is None or self.document.data.blind
        self.running = (
            NOTHING if blind or tau is None else paper_detector_running_offset(self.before, tau)
        )

    def completed(self, frame: int, values: Mapping[str, float]) -> Mapping[str, float]:
        """Return the edited angles of a frame and, if Δθc is one of them, the resulting θc.

        This θc is the θc of the previous frame plus the edited Δθc.
        """
        if "dtheta_c" not in values:
            return values
        sum_before = float(self.before.theta_c[frame] - self.before.dtheta_c[frame])
        return {**values, "theta_c": float(wrap(sum_before + values["dtheta_c"]))}

    def both_angles(self, prefix: str, frame: int) -> Title:
        """Return title parts with θp and θc at a frame, before and after correction.

        `prefix` is '' for the angles themselves, or 'd' for their changes since the previous frame.
        """
        title: Title = []
        for k, name in ANGLES:
            symbol = ("Δ" if prefix else "") + "θ" + k + (" ╌" if k == "c" else "")
            title.append((symbol, "text"))
            turned = prefix + name
            title.append((format_angle_at_frame(getattr(self.before, turned), frame), "before"))
            title.append((format_angle_at_frame(getattr(self.after, turned), frame), "after"))
            title.append(("   ", "soft"))
        return title
