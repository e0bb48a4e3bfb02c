"""The state space and both networks in PyTorch, computing the same as tracker.py and network.py.

torch is an argument or imported when needed, so that the rest of the program does not depend on it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from twistcore.errors import TwistError
from twistcore.formats.smpl.skeleton import JOINTS, PARENTS
from twistcore.quamo import network as net
from twistcore.quamo.state_space import NETWORK_DT, tracker_reference_rotation_step
from twistcore.skeleton.rotation import Array

Tensor = Any  # torch may be missing, and its types with it
Step = Callable[..., tuple[Tensor, Tensor, Tensor, Tensor]]


def import_torch() -> Any:
    """Import and return PyTorch. Raises TwistError with instructions if it is not installed."""
    try:
        import torch
    except ImportError:
        raise TwistError(
            "training requires PyTorch: pip install 'twist-inspector[train]'"
        ) from None
    return torch


def track_windows(
    torch: Any, w: dict[str, Tensor], q_hat: Array, r_hat: Array, step: Step
) -> tuple[Tensor, Tensor]:
    """Track windows of noisy poses with the state space and the networks, as Stepper does.

    Parameters
    ----------
    torch
        The library.
    w
        The weights, keyed by name.
    q_hat
        Noisy poses, shape (windows, frames, 24, 4).
    r_hat
        Noisy root positions, shape (windows, frames, 3).
    step
        The step, from :func:`make_torch_tracking_step`.

    Returns
    -------
    tuple of Tensor
        Tracked poses and root positions, in the same shapes.
    """
    first = np.where(q_hat[:, 0, :, :1] < 0.0, -q_hat[:, 0], q_hat[:, 0])
    delta = np.stack(
        [
            tracker_reference_rotation_step(q_hat[:, t], q_hat[:, t - 1])
            for t in range(1, q_hat.shape[1])
        ],
        axis=1,
    )
    curvature = np.diff(delta, axis=1, prepend=delta[:, :1])
    reference, place, bend = (
        float32_tensor(torch, x).unbind(dim=1) for x in (q_hat, r_hat, curvature)
    )
    q, omega, r, v = _start(
        torch,
        w,
        float32_tensor(torch, first),
        float32_tensor(torch, delta[:, 0]),
        place[0],
        place[1],
    )
    poses, places = [q], [r]
    for t in range(1, q_hat.shape[1]):
        q, omega, r, v = step(w, q, omega, r, v, reference[t], place[t], bend[t - 1])
        poses.append(q)
        places.append(r)
    return torch.stack(poses, dim=1), torch.stack(places, dim=1)


def make_torch_tracking_step(torch: Any, variant: str, compiled: bool = False) -> Step:
    """Return a function of tensors that takes one step of the state space with ControlNet's gains.

    If `compiled` is True, torch.compile fuses the step. This requires a C++ compiler and takes
    about a minute at the start, but halves the duration of an epoch.
    """
    dt, n, exact = NETWORK_DT, 3 * JOINTS, variant in ("s3", "full")

    def step(
        w: dict[str, Tensor],
        q: Tensor,
        omega: Tensor,
        r: Tensor,
        v: Tensor,
        reference: Tensor,
        place: Tensor,
        bend: Tensor,
    ) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        error = _short(torch, _multiply(torch, reference, _conjugate(torch, q)))
        cos, sin = _heading(q[:, 0])
        inputs = torch.cat(
            [
                _pose(torch, w, q),
                net.ERROR_SCALE * _turned(torch, error, cos, sin).flatten(1),
                net.OMEGA_SCALE * _turned(torch, omega, cos, sin).flatten(1),
                net.ERROR_SCALE * _into(torch, place - r, cos, sin),
                _into(torch, v, cos, sin),
                torch.stack([cos, sin], dim=1),
            ],
            dim=1,
        )
        out = _perceptron(torch, w, "control", inputs)
        push = torch.cat([out[:, 3 * n : 4 * n], out[:, -3:]], dim=1) + inputs @ w["control.skip"]
        gain = torch.sigmoid(out[:, : 3 * n]).unflatten(1, (3, JOINTS, 3))
        rate = net.KP * gain[:, 0] * error - net.KD * gain[:, 1] * omega
        root = out[:, 4 * n :]
        pull = net.ROOT_KP * torch.sigmoid(root[:, :3]) * (place - r)
        pull = pull - net.ROOT_KD * torch.sigmoid(root[:, 3:6]) * v
        if variant != "pd":
            bias = net.BIAS * torch.tanh(push[:, :n]).unflatten(1, (JOINTS, 3))
            rate = rate + _turned(torch, bias, cos, -sin)
            pull = pull + _into(torch, net.ROOT_BIAS * torch.tanh(push[:, n:]), cos, -sin)
        if variant == "full":
            rate = rate + net.KA * gain[:, 2] * bend
        omega = (omega + dt * rate).clamp(-25.0, 25.0)
        v = v + dt * pull
        return _moved(torch, q, dt * omega, exact), omega, r + dt * v, v

    return torch.compile(step, fullgraph=True, dynamic=False) if compiled else step


def _start(
    torch: Any, w: dict[str, Tensor], q: Tensor, delta: Tensor, r: Tensor, r_next: Tensor
) -> tuple[Tensor, Tensor, Tensor, Tensor]:
    cos, sin = _heading(q[:, 0])
    rate, speed = 2.0 * delta / NETWORK_DT, (r_next - r) / NETWORK_DT
    inputs = torch.cat(
        [
            _pose(torch, w, q),
            net.OMEGA_SCALE * _turned(torch, rate, cos, sin).flatten(1),
            _into(torch, speed, cos, sin),
            torch.stack([cos, sin], dim=1),
        ],
        dim=1,
    )
    out = _perceptron(torch, w, "init", inputs)
    n = 3 * JOINTS
    phi = _turned(torch, net.START_SCALE * out[:, :n].unflatten(1, (JOINTS, 3)), cos, -sin)
    omega = _turned(torch, out[:, n : 2 * n].unflatten(1, (JOINTS, 3)), cos, -sin)
    return (
        _moved(torch, q, phi, True),
        w["init.share"][0] * rate + omega,
        r + net.START_SCALE * _into(torch, out[:, -6:-3], cos, -sin),
        w["init.share"][1] * speed + _into(torch, out[:, -3:], cos, -sin),
    )


def _perceptron(torch: Any, w: dict[str, Tensor], name: str, h: Tensor) -> Tensor:
    for k in "12":
        h = torch.addmm(w[f"{name}.b{k}"], h, w[f"{name}.w{k}"])
        scale, shift = w[f"{name}.g{k}"], w[f"{name}.c{k}"]
        h = torch.nn.functional.layer_norm(h, scale.shape, scale, shift, net.EPSILON)
        h = torch.nn.functional.leaky_relu(h, net.SLOPE)
    return torch.addmm(w[f"{name}.b3"], h, w[f"{name}.w3"])


def _moved(torch: Any, q: Tensor, phi: Tensor, exact: bool) -> Tensor:
    if not exact:
        turn = torch.cat([torch.ones_like(phi[..., :1]), 0.5 * phi], dim=-1)
        return torch.nn.functional.normalize(_multiply(torch, turn, q), dim=-1)
    # The minimum keeps the gradient of the norm finite at φ = 0.
    half = 0.5 * (phi * phi).sum(dim=-1, keepdim=True).clamp_min(1e-12).sqrt()
    turn = torch.cat([torch.cos(half), (0.5 * torch.sin(half) / half) * phi], dim=-1)
    return _multiply(torch, turn, q)


def root_relative_positions(torch: Any, q: Tensor, offsets: Array) -> Tensor:
    """Return joint positions relative to the root, (windows, frames, 23, 3)."""
    bone = float32_tensor(torch, offsets)[:, None].expand(-1, q.shape[1], -1, -1)
    # A single unbind computes one gradient for all joints instead of 24.
    local, bones = q.unbind(dim=2), bone.unbind(dim=2)
    turned, place = [local[0]], [torch.zeros_like(bones[0])]
    for k in range(1, JOINTS):
        above = turned[PARENTS[k]]
        place.append(place[PARENTS[k]] + _rotate(torch, above, bones[k]))
        turned.append(_multiply(torch, above, local[k]))
    return torch.stack(place[1:], dim=2)


def _multiply(torch: Any, p: Tensor, q: Tensor) -> Tensor:
    pw, pv, qw, qv = p[..., :1], p[..., 1:], q[..., :1], q[..., 1:]
    w = pw * qw - (pv * qv).sum(dim=-1, keepdim=True)
    return torch.cat([w, pw * qv + qw * pv + torch.linalg.cross(pv, qv)], dim=-1)


def _conjugate(torch: Any, q: Tensor) -> Tensor:
    return torch.cat([q[..., :1], -q[..., 1:]], dim=-1)


def _rotate(torch: Any, q: Tensor, v: Tensor) -> Tensor:
    u = q[..., 1:]
    t = 2.0 * torch.linalg.cross(u, v)
    return v + q[..., :1] * t + torch.linalg.cross(u, t)


def _short(torch: Any, q: Tensor) -> Tensor:
    return torch.where(q[..., :1] < 0.0, -q[..., 1:], q[..., 1:])


def _pose(torch: Any, w: dict[str, Tensor], q: Tensor) -> Tensor:
    return (_short(torch, q[:, 1:]).flatten(1) - w["pose.mean"]) / w["pose.scale"]


def _heading(root: Tensor) -> tuple[Tensor, Tensor]:
    w, x, y, z = root.unbind(dim=-1)
    sideways, ahead = 2 * (x * z + w * y), 1 - 2 * (x * x + y * y)
    length = (sideways * sideways + ahead * ahead).clamp_min(1e-12).sqrt()
    return ahead / length, sideways / length


def _into(torch: Any, v: Tensor, cos: Tensor, sin: Tensor) -> Tensor:
    x, y, z = v.unbind(dim=-1)
    return torch.stack([cos * x - sin * z, y, sin * x + cos * z], dim=-1)


def _turned(torch: Any, v: Tensor, cos: Tensor, sin: Tensor) -> Tensor:
    return torch.cat([_into(torch, v[:, :1], cos[:, None], sin[:, None]), v[:, 1:]], dim=1)


def float32_tensor(torch: Any, values: Array) -> Tensor:
    """Return an array as a float32 tensor of the same shape."""
    return torch.as_tensor(np.asarray(values, dtype=np.float32))
