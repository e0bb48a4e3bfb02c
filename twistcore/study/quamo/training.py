"""Train ControlNet and InitNet in PyTorch (`pip install twist-inspector[train]`).

The loss is [Le26 Eq. 6] without its shape term: the L1 errors of joint positions relative to the
root and of the root's position, and of the second differences of both, over 100 steps of the state
space. PyTorch is imported only when training starts.
"""

from __future__ import annotations

import io
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twistcore.errors import TwistError
from twistcore.files.atomic import write_atomically
from twistcore.formats.smpl.skeleton import MIRROR
from twistcore.quamo import network as net
from twistcore.quamo.network import Network, initial_gain_network_for_training
from twistcore.skeleton.rotation import Array, exponential, logarithm, multiply
from twistcore.study.quamo.noise import LEVELS, Noise, add_pose_noise
from twistcore.study.quamo.sequences import Sequence24
from twistcore.study.quamo.torch_model import (
    Step,
    Tensor,
    float32_tensor,
    import_torch,
    make_torch_tracking_step,
    root_relative_positions,
    track_windows,
)


@dataclass(frozen=True)
class TrainingSettings:
    """The settings of a training run. The shipped weights were trained with the defaults.

    Attributes
    ----------
    variant
        Variant of the controller.
    seed
        Seed of all random numbers.
    epochs
        Number of epochs.
    width, init_width
        Width of ControlNet and of InitNet.
    batch
        Number of windows per batch.
    window, stride
        Number of frames in a window, and number of frames between the starts of two windows.
    rate, decay
        Initial learning rate, and weight decay.
    """

    variant: str = "full"
    seed: int = 0
    epochs: int = 60
    width: int = 128
    init_width: int = 32
    batch: int = 32
    window: int = 100
    stride: int = 10
    rate: float = 2e-3
    decay: float = 1e-2


@dataclass(frozen=True, eq=False)
class Batch:
    """Training windows, with and without noise.

    Attributes
    ----------
    q_hat, q
        Noisy and true poses, shape (windows, frames, 24, 4).
    r_hat, r
        Noisy and true root positions, metres, shape (windows, frames, 3).
    offsets
        Offsets of the joints from their parents, metres, shape (windows, 24, 3).
    """

    q_hat: Array
    r_hat: Array
    q: Array
    r: Array
    offsets: Array


def train(
    sequences: Sequence[Sequence24],
    settings: TrainingSettings,
    checkpoint: Path | None = None,
    compiled: bool = False,
    tell: Callable[[str], None] = print,
) -> Network:
    """Train the networks on clips.

    Parameters
    ----------
    sequences
        The clips.
    settings
        The settings.
    checkpoint
        A file to which the state is written after each epoch, and from which training continues.
    compiled
        True to compile the step (see :func:`make_torch_tracking_step`).
    tell
        A function that is called with a line of text after each epoch.

    Raises
    ------
    TwistError
        If PyTorch is not installed, if no clip is as long as a window, or if the checkpoint was
        written with other settings.
    """
    torch = import_torch()
    starts = _starts(sequences, settings)
    if not starts:
        raise TwistError(f"expected a clip of at least {settings.window} frames at 25 Hz")
    torch.manual_seed(settings.seed)
    first = initial_gain_network_for_training(
        settings.width,
        settings.init_width,
        np.random.default_rng([settings.seed, 1]),
        settings.variant,
    )
    first = replace(first, weights={**first.weights, **_pose_statistics(sequences, settings)})
    weights = {
        k: torch.tensor(v, requires_grad=not k.startswith("pose."))
        for k, v in first.weights.items()
    }
    trained = [v for v in weights.values() if v.requires_grad]
    optimiser = torch.optim.AdamW(trained, lr=settings.rate, weight_decay=settings.decay)
    done = 0
    if checkpoint and checkpoint.exists():
        done = _resume(torch, checkpoint, settings, weights, optimiser)
    step = make_torch_tracking_step(torch, settings.variant, compiled)
    begin = time.perf_counter()
    for epoch in range(done, settings.epochs):
        rate = settings.rate * 0.1 ** sum(
            epoch >= share * settings.epochs for share in (4 / 7, 6 / 7)
        )
        for group in optimiser.param_groups:
            group["lr"] = rate
        losses = []
        for batch in batches(sequences, starts, settings, epoch):
            loss = window_loss(torch, weights, batch, step)
            optimiser.zero_grad()
            loss.backward()
            torch.nn.utils.clip_grad_norm_(trained, 1.0)
            optimiser.step()
            losses.append(float(loss.detach()))
        if checkpoint:
            _keep(torch, checkpoint, settings, weights, optimiser, epoch + 1)
        seconds = time.perf_counter() - begin
        tell(f"epoch {epoch + 1}/{settings.epochs}: loss {np.mean(losses):.5f}, {seconds:.0f} s")
    arrays = {k: v.detach().numpy().copy() for k, v in weights.items()}
    return Network(arrays, settings.variant)


def batches(
    sequences: Sequence[Sequence24],
    starts: Sequence[tuple[int, int]],
    settings: TrainingSettings,
    epoch: int,
) -> Iterator[Batch]:
    """Yield the training windows of an epoch in random order, mirrored, rotated and with noise.

    Mirroring, rotation and noise are random. They depend only on the seed of the settings and on
    the epoch, so that a resumed run gives the same result. `starts` lists the index of the clip and
    the first frame of each window.
    """
    rng = np.random.default_rng([settings.seed, 2, epoch])
    spread = _spread(sequences)
    clips = [_augmented(s, rng, spread) for s in sequences]
    order = rng.permutation(len(starts))
    for a in range(0, len(order) - settings.batch // 2, settings.batch):
        chosen = [starts[k] for k in order[a : a + settings.batch]]
        parts = [
            [clips[c][k][s : s + settings.window] for k in range(4)] + [clips[c][4]]
            for c, s in chosen
        ]
        q_hat, r_hat, q, r, offsets = (np.stack(p) for p in zip(*parts, strict=True))
        origin = r_hat[:, :1].copy()
        yield Batch(q_hat, r_hat - origin, q, r - origin, offsets)


def _starts(sequences: Sequence[Sequence24], settings: TrainingSettings) -> list[tuple[int, int]]:
    return [
        (c, start)
        for c, sequence in enumerate(sequences)
        for start in range(0, len(sequence.q) - settings.window + 1, settings.stride)
    ]


def _pose_statistics(
    sequences: Sequence[Sequence24], settings: TrainingSettings
) -> dict[str, NDArray[np.float32]]:
    """Return the mean and the standard deviation of the pose inputs with training noise."""
    rng = np.random.default_rng([settings.seed, 3])
    spread = _spread(sequences)
    poses = np.concatenate(
        [
            net.network_pose_inputs(_augmented(s, rng, spread)[0])
            for s in sequences
            for _ in range(2)
        ]
    )
    return {
        "pose.mean": poses.mean(axis=0).astype(np.float32),
        "pose.scale": np.maximum(poses.std(axis=0), 1e-3).astype(np.float32),
    }


def _spread(sequences: Sequence[Sequence24]) -> Array:
    """Return the standard deviation of each joint's rotation vector, (24, 3); 0 for the root."""
    spread: Array = np.concatenate([logarithm(s.q) for s in sequences]).std(axis=0)
    spread = np.maximum(spread, spread[list(MIRROR)])
    spread[0] = 0.0
    return spread


def _augmented(
    sequence: Sequence24, rng: np.random.Generator, spread: Array
) -> tuple[Array, Array, Array, Array, Array]:
    # Rotate each joint by a constant random angle as large as its usual movement, so that the
    # network learns how far joints rotate and not the posture of these people.
    posture = rng.standard_normal(spread.shape) * spread
    q, r, offsets = multiply(exponential(posture), sequence.q), sequence.r, sequence.offsets
    if rng.random() < 0.5:
        flip = np.array([-1.0, 1.0, 1.0])
        q = q[:, list(MIRROR)] * np.array([1.0, 1.0, -1.0, -1.0])
        r, offsets = r * flip, offsets[list(MIRROR)] * flip
    yaw = rng.uniform(-np.pi, np.pi)
    turn = exponential(np.array([0.0, yaw, 0.0]))
    q = q.copy()
    q[:, 0] = multiply(turn, q[:, 0])
    c, s = np.cos(yaw), np.sin(yaw)
    r = np.stack([c * r[:, 0] + s * r[:, 2], r[:, 1], c * r[:, 2] - s * r[:, 0]], axis=1)
    noise = Noise(LEVELS[str(rng.choice(list(LEVELS)))], systematic=bool(rng.random() < 0.5))
    q_hat, r_hat = add_pose_noise(q, r, noise, rng)
    return q_hat, r_hat, q, r, offsets


def window_loss(torch: Any, w: dict[str, Tensor], batch: Batch, step: Step) -> Tensor:
    """Return the sum of the L1 errors of positions and of their second differences, in metres."""
    q, r = track_windows(torch, w, batch.q_hat, batch.r_hat, step)
    found, found_r = root_relative_positions(torch, q, batch.offsets), r
    truth = root_relative_positions(torch, float32_tensor(torch, batch.q), batch.offsets)
    truth_r = float32_tensor(torch, batch.r)

    def bent(x: Tensor) -> Tensor:
        return x[:, :-2] - 2.0 * x[:, 1:-1] + x[:, 2:]

    total: Tensor = 0.0
    for a, b in ((found, truth), (found_r, truth_r)):
        total = total + (a - b).abs().mean() + (bent(a) - bent(b)).abs().mean()
    return total


def _settings_text(settings: TrainingSettings) -> str:
    """Return the settings as text for checkpoints.

    The text begins with an earlier name of the class, so that earlier checkpoints can be used.
    """
    return repr(settings).removeprefix("Training")


def _keep(
    torch: Any, path: Path, settings: TrainingSettings, weights: Any, optimiser: Any, epoch: int
) -> None:
    state = {
        "settings": _settings_text(settings),
        "epoch": epoch,
        "weights": {k: v.detach() for k, v in weights.items()},
        "optimiser": optimiser.state_dict(),
    }
    buffer = io.BytesIO()
    torch.save(state, buffer)
    write_atomically(path, buffer.getvalue())


def _resume(
    torch: Any, path: Path, settings: TrainingSettings, weights: Any, optimiser: Any
) -> int:
    state = torch.load(path, weights_only=True)
    if state["settings"] != (expected := _settings_text(settings)):
        raise TwistError(
            f"{path}: the checkpoint was written with other settings; expected {expected}"
        )
    with torch.no_grad():
        for name, values in weights.items():
            values.copy_(state["weights"][name])
    optimiser.load_state_dict(state["optimiser"])
    return int(state["epoch"])
