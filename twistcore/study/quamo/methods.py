"""The methods in QuaMo's tables: trackers, rival filters, other representations, and networks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np

from twistcore.quamo.both_ways import track_both_ways
from twistcore.quamo.network import Network
from twistcore.quamo.state_space import EXACT, FIRST_ORDER, NETWORK_DT, Gains
from twistcore.quamo.tracker import HandGains, track
from twistcore.skeleton.rotation import Array
from twistcore.study.quamo.pose_errors import lag_numerator_and_denominator
from twistcore.study.quamo.representations import (
    REPRESENTATIONS,
    Representation,
    has_root_discontinuity,
    track_coordinates,
    track_root_positions,
)
from twistcore.study.quamo.rivals import (
    RIVALS,
    Rival,
    mean_rotation_offset,
    rotate_joints_by_fitted_offsets,
)
from twistcore.study.quamo.sequences import Sequence24
from twistcore.study.quamo.tables import CONDITIONS, Method, noisy_clip

HAND, HAND_FIRST_ORDER, HAND_ALPHA = "hand gains", "hand gains, first-order", "hand gains + α"
HAND_ROOT_SUBSTEPS = "hand gains, root in six sub-steps"
FULL = "learned, full"
BOTH_WAYS, FULL_BOTH_WAYS, SPLINE = "both ways, file", "learned both ways, file", "spline, file"
# Chosen on subjects 02, 08 and 12, so that Accel at level A grows by a quarter.
HAND_ACCELERATION = 150.0
_ROOT_SUBSTEPS = 6  # number of steps in NeurPhys, according to [Le26 supplement F]
_TRAIN_SEED = 100  # no table uses this seed


def baseline_methods(sequences: Sequence[Sequence24]) -> dict[str, Method]:
    """Return the methods for comparison: a constant offset, and the tuned rival filters.

    The offset for a clip is fitted on the clips of other subjects. Causal rivals come first.
    """

    @cache
    def offset(subject: str) -> Array:
        others = [s for s in sequences if s.subject != subject] or sequences
        noise = CONDITIONS[-1].noise
        return mean_rotation_offset((noisy_clip(s, noise, _TRAIN_SEED)[0], s.q) for s in others)

    def rival_method(rival: Rival) -> Method:
        return lambda _, q_hat, r_hat: rival.run(q_hat, r_hat, NETWORK_DT)

    return {
        "constant offset": lambda s, q, r: (
            rotate_joints_by_fitted_offsets(q, offset(s.subject)),
            r,
        ),
        **{rival.name: rival_method(rival) for rival in RIVALS},
    }


def hand_tuned_method(gains: Gains | None = None, integration: str = EXACT) -> Method:
    """Return a method that tracks clips at 25 Hz with hand-tuned gains."""

    def run(_: Sequence24, q_hat: Array, r_hat: Array) -> tuple[Array, Array]:
        found = track(q_hat, r_hat, NETWORK_DT, HandGains(gains), integration=integration)
        return found.q, found.r

    return run


def track_hand_tuned_forward_backward(
    _: Sequence24, q_hat: Array, r_hat: Array
) -> tuple[Array, Array]:
    """Track forward and backward in time with hand-tuned gains at 25 Hz."""
    found = track_both_ways(q_hat, r_hat, NETWORK_DT, HandGains())
    return found.q, found.r


def track_root_in_substeps(clip: Sequence24, q_hat: Array, r_hat: Array) -> tuple[Array, Array]:
    """Track with hand-tuned gains and six Euler steps per frame for the root [Le26 supp. F]."""
    q, _ = hand_tuned_method()(clip, q_hat, r_hat)
    return q, track_root_positions(r_hat, NETWORK_DT, Gains(), _ROOT_SUBSTEPS)


def hand_tuned_methods() -> dict[str, Method]:
    """Return the methods with hand-tuned gains, which do not need training."""
    return {
        HAND: hand_tuned_method(),
        HAND_FIRST_ORDER: hand_tuned_method(integration=FIRST_ORDER),
        HAND_ALPHA: hand_tuned_method(Gains(ka=HAND_ACCELERATION)),
        HAND_ROOT_SUBSTEPS: track_root_in_substeps,
    }


def tracking_methods_by_representation() -> dict[str, Method]:
    """Return methods with hand-tuned gains for other representations of rotations."""

    def method(rep: Representation) -> Method:
        return lambda _, q_hat, r_hat: (
            track_coordinates(q_hat, NETWORK_DT, rep, Gains()),
            track_root_positions(r_hat, NETWORK_DT, Gains()),
        )

    return {rep.name: method(rep) for rep in REPRESENTATIONS}


def learned_method(by_subject: Mapping[str, Network], *, both_ways: bool = False) -> Method:
    """Return a method that tracks each clip with a network trained without the clip's subject."""
    way = track_both_ways if both_ways else track

    def run(sequence: Sequence24, q_hat: Array, r_hat: Array) -> tuple[Array, Array]:
        network = by_subject[sequence.subject]
        controller = network.started(q_hat, r_hat)
        found = way(q_hat, r_hat, NETWORK_DT, controller, integration=network.integration)
        return found.q, found.r

    return run


def select_root_discontinuity_clips(sequences: Sequence[Sequence24]) -> tuple[Sequence24, ...]:
    """Return the clips in which the root crosses a discontinuity of at least one representation."""
    return tuple(s for s in sequences if has_root_discontinuity(s.q))


def measured_lags(
    sequences: Sequence[Sequence24], methods: Mapping[str, Method]
) -> dict[str, Array]:
    """Return the lags of each method in milliseconds on clips without noise, keyed by method.

    Each entry contains the lag of the joints relative to the root, and the lag of the root's
    position, shape (2,). All clips are measured together.
    """
    found = {}
    for name, method in methods.items():
        sums = np.zeros((2, 2))
        for sequence in sequences:
            q, r = method(sequence, sequence.q[:, None], sequence.r[:, None])
            here = sequence.places_mm(q[:, 0], r[:, 0])
            truth = sequence.places_mm(sequence.q, sequence.r)
            sums[0] += lag_numerator_and_denominator(
                here - here[:, :1], truth - truth[:, :1], NETWORK_DT
            )
            sums[1] += lag_numerator_and_denominator(here[:, 0], truth[:, 0], NETWORK_DT)
        found[name] = 1000.0 * sums[:, 0] / sums[:, 1]
    return found
