"""The networks that compute gains (ControlNet) and the initial state (InitNet), in numpy.

Both are described in [Le26 §3.1, supplement A]. Each has two hidden layers (linear, LayerNorm,
LeakyReLU) and a linear output layer. In ControlNet, a linear skip connection from the inputs to the
bias helps to keep joints still if they hardly rotate. The inputs are poses, errors and velocities.
They are relative to the parent joint or, for the root, to the heading of the body. No input is a
position in world space. There are separate gains for each axis of the 24 joints and of the root's
position.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import FormatError
from twistcore.files.atomic import write_atomically
from twistcore.formats.smpl.skeleton import JOINTS
from twistcore.quamo.stability import UnstableGainsError, check_stability
from twistcore.quamo.state_space import (
    EXACT,
    FIRST_ORDER,
    NETWORK_DT,
    Gains,
    canonical_vector_part,
    tracker_reference_rotation_step,
)
from twistcore.quamo.tracker import Controller, State
from twistcore.skeleton.rotation import Array, conjugate, exponential, multiply
from twistcore.work.frozen import dataclass

Float32 = NDArray[np.float32]

KP, KD, KA, BIAS = 1000.0, 30.0, 1000.0, 25.0  # largest gains of joints, in the units of `Gains`
ROOT_KP, ROOT_KD, ROOT_BIAS = 400.0, 30.0, 10.0  # largest gains of the root's position
ERROR_SCALE, OMEGA_SCALE = 5.0, 0.3  # factors that scale errors and velocities to about 1
SLOPE = 0.01  # slope of LeakyReLU below 0
EPSILON = 1e-5  # ε of LayerNorm
START_SCALE = 0.1  # radians and metres per unit of InitNet's output for the initial pose

_VECTOR = 3 * JOINTS  # a vector for each joint
_POSE = _VECTOR - 3  # a vector for each joint except the root
CONTROL_INPUTS = _POSE + 2 * _VECTOR + 8
CONTROL_OUTPUTS = 4 * _VECTOR + 9
BIAS_OUTPUTS = np.r_[3 * _VECTOR : 4 * _VECTOR, CONTROL_OUTPUTS - 3 : CONTROL_OUTPUTS]
INIT_INPUTS = _POSE + _VECTOR + 5
INIT_OUTPUTS = 2 * _VECTOR + 6

# The variants of [Le26 Table 3]. Each adds a part to the previous one.
VARIANTS = {
    "pd": "PD gains only, first-order integration",
    "bias": "with the bias f_ω",
    "s3": "with exact integration on S³",
    "full": "with the acceleration term α",
}


@dataclass(frozen=True, eq=False)
class Network:
    """The weights of ControlNet and InitNet.

    Attributes
    ----------
    weights
        The arrays of :func:`network_weight_shapes`, float32, keyed by name.
    variant
        The variant, a key of VARIANTS.
    note
        A line of text about the training (data, seed, epochs), which is stored in the file.
    """

    weights: Mapping[str, Float32]
    variant: str = "full"
    note: str = ""

    @property
    def integration(self) -> str:
        """The integration that the tracker must use: 'exact' or 'first-order'."""
        return FIRST_ORDER if self.variant in ("pd", "bias") else EXACT

    @property
    def width(self) -> int:
        """The number of units in a hidden layer of ControlNet."""
        return len(self.weights["control.b1"])

    def started(self, q_hat: Array, r_hat: Array) -> NetworkController:
        """Return a controller for tracking a clip with these weights.

        The noisy input of the clip consists of the rotations `q_hat`, shape (frames, …, 24, 4), and
        the root positions `r_hat` in metres, shape (frames, …, 3). The first two frames determine
        the initial state.
        """
        return NetworkController(self, q_hat[:2], r_hat[:2])


class NetworkController(Controller):
    """A controller that computes gains with ControlNet and the initial state with InitNet.

    InitNet needs the first two references, so the first pose is delayed by one 25 Hz sample.
    """

    def __init__(self, network: Network, q_hat: Array, r_hat: Array) -> None:
        self.network, self._q, self._r = network, q_hat, r_hat

    def both_ways(self, q_two: Array, r_two: Array) -> NetworkController:
        """Return a controller for a forward and a backward pass, each with its initial state."""
        return self.network.started(q_two, r_two)

    def start(self, q_hat: Array, r_hat: Array) -> State:
        """Return the initial state from InitNet.

        The rotations are Exp(φ) ⊗ q̂, where φ is an output of InitNet. If there are fewer than two
        references, the initial state is the first reference with zero velocity.
        """
        if len(self._q) < 2:
            return super().start(q_hat, r_hat)
        w = self.network.weights
        cos, sin = root_heading_cosine_and_sine(q_hat[..., 0, :])
        rate = 2.0 * tracker_reference_rotation_step(self._q[1], self._q[0]) / NETWORK_DT
        speed = (self._r[1] - self._r[0]) / NETWORK_DT
        inputs = np.concatenate(
            [
                standardise_pose_inputs(w, network_pose_inputs(q_hat)),
                OMEGA_SCALE * _flat(_root_turned(rate, cos, sin)),
                _into(speed, cos, sin),
                np.stack([cos, sin], axis=-1),
            ],
            axis=-1,
        )
        out = _perceptron(w, "init", inputs)
        shape = (*q_hat.shape[:-1], 3)
        phi = _root_back(START_SCALE * out[..., :_VECTOR].reshape(shape), cos, sin)
        omega = _root_back(out[..., _VECTOR : 2 * _VECTOR].reshape(shape), cos, sin)
        place, velocity = out[..., -6:-3], out[..., -3:]
        share = w["init.share"].astype(np.float64)
        return State(
            multiply(exponential(phi), q_hat),
            share[0] * rate + omega,
            r_hat + START_SCALE * _back(place, cos, sin),
            share[1] * speed + _back(velocity, cos, sin),
        )

    def gains(self, state: State, q_hat: Array, r_hat: Array, dt: float) -> Gains:
        """Return the gains of a step, computed by ControlNet.

        Raises UnstableGainsError if `dt` is not 0.04 s, the frame time of the training.
        """
        if abs(dt - NETWORK_DT) > 1e-6:
            raise UnstableGainsError(f"learned gains work at 25 Hz, not at {1.0 / dt:g}")
        w = self.network.weights
        inputs, (cos, sin) = control_network_inputs(w, state, q_hat, r_hat)
        out = _perceptron(w, "control", inputs)
        out[..., BIAS_OUTPUTS] += inputs.astype(np.float32) @ w["control.skip"]
        return gains_from_network_outputs(out, cos, sin, self.network.variant)


def control_network_inputs(
    w: Mapping[str, Float32], state: State, q_hat: Array, r_hat: Array
) -> tuple[Array, tuple[Array, Array]]:
    """Return the inputs of ControlNet, (…, CONTROL_INPUTS), and the heading (cos ψ, sin ψ)."""
    cos, sin = root_heading_cosine_and_sine(state.q[..., 0, :])
    error = canonical_vector_part(multiply(q_hat, conjugate(state.q)))
    inputs = np.concatenate(
        [
            standardise_pose_inputs(w, network_pose_inputs(state.q)),
            ERROR_SCALE * _flat(_root_turned(error, cos, sin)),
            OMEGA_SCALE * _flat(_root_turned(state.omega, cos, sin)),
            ERROR_SCALE * _into(r_hat - state.r, cos, sin),
            _into(state.v, cos, sin),
            np.stack([cos, sin], axis=-1),
        ],
        axis=-1,
    )
    return inputs, (cos, sin)


def gains_from_network_outputs(out: Array, cos: Array, sin: Array, variant: str) -> Gains:
    """Convert the outputs of ControlNet, (…, CONTROL_OUTPUTS), to gains.

    The outputs are scaled to the ranges of the gains, and the root's bias is rotated from the
    heading (cos ψ, sin ψ) back to world axes.
    """
    shape = (*out.shape[:-1], JOINTS, 3)
    kp, kd, ka, bias, root = np.split(out, np.arange(1, 5) * _VECTOR, axis=-1)
    with_bias, with_acceleration = variant != "pd", variant == "full"
    return Gains(
        kp=KP * _sigmoid(kp).reshape(shape),
        kd=KD * _sigmoid(kd).reshape(shape),
        ka=KA * _sigmoid(ka).reshape(shape) if with_acceleration else 0.0,
        bias=_root_back(BIAS * np.tanh(bias).reshape(shape), cos, sin) if with_bias else 0.0,
        root_kp=ROOT_KP * _sigmoid(root[..., :3]),
        root_kd=ROOT_KD * _sigmoid(root[..., 3:6]),
        root_bias=_back(ROOT_BIAS * np.tanh(root[..., 6:]), cos, sin) if with_bias else 0.0,
    )


def network_pose_inputs(q: Array) -> Array:
    """Return vec(±q) (:func:`canonical_vector_part`) of the 23 joints below the root, (…, 24, 4) →
    (…, 69).

    The tilt of the root is not an input, because the network would overfit to the ways in which the
    training subjects bend and lie.
    """
    return _flat(canonical_vector_part(q[..., 1:, :]))


def standardise_pose_inputs(w: Mapping[str, Float32], pose: Array) -> Array:
    """Standardise pose inputs with their mean and standard deviation in the training data.

    As a result, one degree has more weight in a joint that hardly rotates than in a joint that
    rotates far.
    """
    return (pose - w["pose.mean"]) / w["pose.scale"]


def root_heading_cosine_and_sine(root: Array) -> tuple[Array, Array]:
    """Return (cos ψ, sin ψ) of the heading ψ, the direction of the root's z axis on the ground.

    `root` contains the rotations of the root, (…, 4).
    """
    w, x, y, z = (root[..., i] for i in range(4))
    sideways, ahead = 2 * (x * z + w * y), 1 - 2 * (x * x + y * y)
    length = np.maximum(np.hypot(sideways, ahead), 1e-6)
    return ahead / length, sideways / length


def _into(v: Array, cos: Array, sin: Array) -> Array:
    """Rotate vectors, (…, 3), from world axes to axes aligned with the heading (cos ψ, sin ψ)."""
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    return np.stack([cos * x - sin * z, y, sin * x + cos * z], axis=-1)


def _back(v: Array, cos: Array, sin: Array) -> Array:
    """Rotate vectors, (…, 3), from axes aligned with the heading (cos ψ, sin ψ) to world axes."""
    return _into(v, cos, -sin)


def _root_turned(v: Array, cos: Array, sin: Array) -> Array:
    """Apply :func:`_into` to the root's vectors.

    `v` contains the vectors of all joints, (…, joints, 3). All other vectors remain unchanged.
    """
    out = v.copy()
    out[..., 0, :] = _into(v[..., 0, :], cos, sin)
    return out


def _root_back(v: Array, cos: Array, sin: Array) -> Array:
    return _root_turned(v, cos, -sin)


def _flat(v: Array) -> Array:
    return v.reshape(*v.shape[:-2], -1)


def _sigmoid(x: Array) -> Array:
    return 0.5 * (1.0 + np.tanh(0.5 * x))


def _perceptron(w: Mapping[str, Float32], name: str, inputs: Array) -> Array:
    h = inputs.astype(np.float32)
    for k in ("1", "2"):
        h = h @ w[f"{name}.w{k}"] + w[f"{name}.b{k}"]
        h = h - h.mean(axis=-1, keepdims=True)
        h = h / np.sqrt((h * h).mean(axis=-1, keepdims=True) + np.float32(EPSILON))
        h = h * w[f"{name}.g{k}"] + w[f"{name}.c{k}"]
        h = np.maximum(h, np.float32(SLOPE) * h)
    return (h @ w[f"{name}.w3"] + w[f"{name}.b3"]).astype(np.float64)


def network_weight_shapes(width: int, init_width: int) -> dict[str, tuple[int, ...]]:
    """Return the shapes of the arrays of a network, keyed by name.

    `width` and `init_width` are the numbers of units in the hidden layers of ControlNet and
    InitNet.
    """
    shapes: dict[str, tuple[int, ...]] = {
        "init.share": (2,),
        "pose.mean": (_POSE,),
        "pose.scale": (_POSE,),
        "control.skip": (CONTROL_INPUTS, len(BIAS_OUTPUTS)),
    }
    for name, n, inputs, outputs in (
        ("control", width, CONTROL_INPUTS, CONTROL_OUTPUTS),
        ("init", init_width, INIT_INPUTS, INIT_OUTPUTS),
    ):
        for k, (a, b) in enumerate(((inputs, n), (n, n), (n, outputs)), 1):
            shapes |= {f"{name}.w{k}": (a, b), f"{name}.b{k}": (b,)}
        shapes |= {f"{name}.{p}{k}": (n,) for p in "gc" for k in "12"}
    return shapes


def initial_gain_network_for_training(
    width: int, init_width: int, rng: np.random.Generator, variant: str
) -> Network:
    """Return a network to train. Its hidden layers are random, and it outputs the hand-tuned gains.

    κA is 20, since a sigmoid cannot be 0. All other gains are the defaults of :class:`Gains`.
    """
    weights: dict[str, Float32] = {}
    for name, shape in network_weight_shapes(width, init_width).items():
        kind = name.split(".")[1]
        if kind in ("w1", "w2"):
            values = rng.standard_normal(shape) / np.sqrt(shape[0])
        else:
            values = np.full(shape, 1.0 if kind in ("g1", "g2", "scale") else 0.0)
        weights[name] = values.astype(np.float32)
    hand = Gains()
    b3 = weights["control.b3"]
    for start, share in (
        (0, hand.kp / KP),
        (_VECTOR, hand.kd / KD),
        (2 * _VECTOR, 20.0 / KA),
        (4 * _VECTOR, hand.root_kp / ROOT_KP),
        (4 * _VECTOR + 3, hand.root_kd / ROOT_KD),
    ):
        stop = start + (_VECTOR if start < 4 * _VECTOR else 3)
        b3[start:stop] = np.log(share / (1.0 - np.asarray(share)))
    weights["init.share"][:] = 0.5, 0.3
    return Network(weights, variant)


def write_gain_network_weights(network: Network, path: Path) -> None:
    """Write the weights of a network as float16, atomically.

    Writing the same network again produces the same bytes.
    """
    buffer = io.BytesIO()
    arrays = {name: values.astype(np.float16) for name, values in network.weights.items()}
    arrays["variant"] = np.array(network.variant)
    arrays["note"] = np.array(network.note)
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, values in arrays.items():
            member = io.BytesIO()
            np.save(member, values)
            # With a fixed time stamp, the bytes depend only on the weights.
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), member.getvalue())
    write_atomically(path, buffer.getvalue())


def read_network(path: Path) -> Network:
    """Read and check the weights of a network.

    Raises FormatError if the file does not contain a network.
    """
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
    except (ValueError, zipfile.BadZipFile, EOFError) as error:
        raise FormatError(f"{path}: expected weights as .npz ({error})") from None
    variant, note = (str(arrays.pop(k, "")) for k in ("variant", "note"))
    if variant not in VARIANTS:
        raise FormatError(
            f"{path}: expected weights of one of {', '.join(VARIANTS)}, found {variant!r}"
        )
    sizes = [
        arrays[k].shape[0] if k in arrays and arrays[k].ndim else 0
        for k in ("control.b1", "init.b1")
    ]
    for name, shape in network_weight_shapes(*sizes).items():
        if name not in arrays:
            raise FormatError(f"{path}: expected the array {name!r}, found none")
        if arrays[name].shape != shape or arrays[name].dtype.kind != "f":
            raise FormatError(
                f"{path}: expected {name!r} of shape {shape}, found {arrays[name].shape}"
            )
        if not np.isfinite(arrays[name]).all():
            raise FormatError(f"{path}: expected finite weights in {name!r}")
    # All gains are between 0 and these values, so it is enough to check the largest.
    check_stability(Gains(kp=KP, kd=KD, root_kp=ROOT_KP, root_kd=ROOT_KD), NETWORK_DT)
    return Network({k: v.astype(np.float32) for k, v in arrays.items()}, variant, note)
