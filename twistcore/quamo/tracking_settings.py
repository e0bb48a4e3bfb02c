"""The settings with which QuaMo tracks or smooths a clip, as they are stored in sessions."""

from __future__ import annotations

from twistcore.work.frozen import dataclass


@dataclass(frozen=True)
class Tracking:
    """The joints to track or smooth after the twist correction, and the settings.

    Parameters
    ----------
    joints
        The joints' names, in the skeleton's order. Empty if only the position is tracked.
    kp, kd, ka
        The gains κP (1/s²), κD (1/s) and κA, unless `learned` is True.
    learned
        True to use gains from the included networks.
    weights
        The first 16 digits of the SHA-256 of the networks' file, or '' for gains set by hand.
    causal
        True to track only forward in time, False to track forward and backward.
    place
        True to track the position of the figure as well.
    spline
        True to smooth with a spline, which has no gains, instead of tracking.
    cutoff
        The cut-off frequency of the spline in Hz.
    bursts
        The joint and the frames [start, stop) of each noise burst to smooth. Empty to smooth the
        whole clip.
    """

    joints: tuple[str, ...]
    kp: float = 600.0
    kd: float = 15.0
    ka: float = 0.0
    learned: bool = False
    weights: str = ""
    causal: bool = True
    place: bool = False
    spline: bool = False
    cutoff: float = 0.0
    bursts: tuple[tuple[str, int, int], ...] = ()

    @property
    def what(self) -> str:
        """A short description of the tracked parts, such as '2 joints and the position'."""
        joints = self.joints[0] if len(self.joints) == 1 else f"{len(self.joints)} joints"
        if self.bursts:
            count = len({(start, stop) for _, start, stop in self.bursts})
            return f"{joints} in one burst" if count == 1 else f"{joints} in {count} bursts"
        return " and ".join((joints,) * bool(self.joints) + ("the position",) * self.place)
