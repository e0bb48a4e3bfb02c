"""Track a stream of noisy poses, one at a time."""

from __future__ import annotations

from numpy.typing import ArrayLike

from twistcore.errors import TwistError
from twistcore.quamo.tracker import Controller, HandGains, Stepper
from twistcore.skeleton.rotation import Array


class Tracker:
    """A tracker that removes jitter from a stream of poses without waiting for later poses.

    The results are the same as those of :func:`track` and of `twistcore quamo refine --causal`. A
    new stream, or a stream after a cut, needs a new tracker.

    Parameters
    ----------
    fps
        The number of poses per second, on which the default gains depend.
    controller
        The source of the gains, by default :class:`HandGains`.

    Raises
    ------
    TwistError
        If the number of poses per second is not positive.

    Examples
    --------
    >>> import twistcore as tc
    >>> tracker = tc.Tracker(fps=60)
    >>> rotations, position = tracker.step(([[1.0, 0.0, 0.0, 0.0]], [0.0, 0.9, 0.0]))
    >>> rotations.shape, position.shape
    ((1, 4), (3,))
    """

    def __init__(self, fps: float, controller: Controller | None = None) -> None:
        if not 0.0 < fps < float("inf"):
            raise TwistError(f"expected a number of poses per second above 0, found {fps:g}")
        self._dt = 1.0 / fps
        self._stepper = Stepper(controller or HandGains())

    def step(self, pose: tuple[ArrayLike, ArrayLike]) -> tuple[Array, Array]:
        """Return the tracked pose after the next pose of the stream.

        Parameters
        ----------
        pose
            The rotations of all joints relative to their parents, as quaternions (w, x, y, z) of
            either sign, shape (joints, 4), and the root's position, shape (3,), in any unit.

        Returns
        -------
        tuple
            The tracked rotations and position, with the same shapes. With hand-tuned gains, the
            tracker starts exactly at the first pose.

        Raises
        ------
        TwistError
            If a number is not finite or a quaternion has length 0.
        UnstableGainsError
            If the gains of the controller diverge at this number of poses per second.
        """
        state = self._stepper.step(*pose, self._dt).state
        return state.q, state.r
