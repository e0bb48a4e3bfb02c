"""ControlNet and InitNet in numpy: the gains of hands untrained, relative inputs, files, torch."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import ASSETS
from twistcore.errors import FormatError, TwistError
from twistcore.quamo import Gains, HandGains, UnstableGainsError, network, track
from twistcore.quamo.network import (
    VARIANTS,
    Network,
    initial_gain_network_for_training,
    read_network,
    write_gain_network_weights,
)
from twistcore.skeleton.rotation import exponential, geodesic_angle, multiply, rotate
from twistcore.study.quamo.noise import LEVELS, Noise, add_pose_noise
from twistcore.study.quamo.sequences import read_cmu_bvh_sequence
from twistcore.study.quamo.torch_model import import_torch, make_torch_tracking_step, track_windows
from twistcore.study.quamo.training import TrainingSettings, batches, train

needs_torch = pytest.mark.skipif(
    importlib.util.find_spec("torch") is None, reason="PyTorch is an extra"
)


def shaken(variant: str, width: int = 16) -> Network:
    """A network whose every weight matters."""
    rng = np.random.default_rng(3)
    start = initial_gain_network_for_training(width, 8, rng, variant)
    weights = {
        k: (v + 0.05 * rng.standard_normal(v.shape)).astype(np.float32)
        for k, v in start.weights.items()
    }
    return replace(start, weights=weights)


def run(net, q, r):
    return track(q, r, 0.04, net.started(q, r), integration=net.integration)


def dance():
    s = read_cmu_bvh_sequence(ASSETS / "dance.bvh")
    return add_pose_noise(s.q, s.r, Noise(LEVELS["A"]), np.random.default_rng(0))


@pytest.fixture(scope="module")
def reference():
    return dance()


def test_untrained_it_is_the_gains_of_hands(reference):
    q, r = reference
    net = initial_gain_network_for_training(16, 8, np.random.default_rng(0), "full")
    found, hand = run(net, q, r), track(q, r, 0.04, HandGains(Gains(ka=20.0)))
    # They start differently (InitNet takes a part of the first velocity) and soon agree.
    assert np.degrees(geodesic_angle(found.q[40:], hand.q[40:])).max() < 0.05
    assert found.r[40:] == pytest.approx(hand.r[40:], abs=1e-3)


def test_the_sign_of_a_reference_changes_no_bit(reference):
    q, r = reference
    flipped = np.where(np.random.default_rng(0).random((*q.shape[:2], 1)) < 0.5, -q, q)
    a, b = (run(shaken("full"), x, r) for x in (q, flipped))
    assert (a.q == b.q).all()
    assert (a.r == b.r).all()


def test_a_prefix_gives_the_same_bits(reference):
    q, r = reference
    whole, part = run(shaken("full"), q, r), run(shaken("full"), q[:30], r[:30])
    assert (part.q == whole.q[:30]).all()
    assert (part.r == whole.r[:30]).all()


def test_a_place_in_the_room_does_not_matter(reference):
    q, r = reference
    moved = np.array([5.0, 0.0, -3.0])
    here, there = run(shaken("full"), q, r), run(shaken("full"), q, r + moved)
    assert np.degrees(geodesic_angle(here.q, there.q)).max() < 0.01
    assert there.r == pytest.approx(here.r + moved, abs=1e-4)


def test_bias_is_turned_with_the_heading(reference):
    """Everything but the gains of an axis and the heading itself turns with the body."""
    net = shaken("full")
    weights = dict(net.weights)
    for name in ("control.w1", "control.skip"):
        weights[name] = weights[name].copy()
        weights[name][-2:] = 0.0  # blind to the heading itself
    net = replace(net, weights=weights)
    q, r = reference
    turn = exponential(np.array([0.0, 1.2, 0.0]))
    turned = q.copy()
    turned[:, 0] = multiply(turn, q[:, 0])
    c = net.started(q, r)
    state = c.start(q[0], r[0])
    other = replace(
        state,
        q=np.concatenate([multiply(turn, state.q[:1]), state.q[1:]]),
        omega=np.concatenate([rotate(turn, state.omega[:1]), state.omega[1:]]),
        r=rotate(turn, state.r),
        v=rotate(turn, state.v),
    )
    one = c.gains(state, q[1], r[1], 0.04)
    two = c.gains(other, turned[1], rotate(turn, r[1]), 0.04)
    assert rotate(turn, one.bias[0]) == pytest.approx(two.bias[0], abs=1e-4)
    assert rotate(turn, one.root_bias) == pytest.approx(two.root_bias, abs=1e-4)
    assert one.bias[1:] == pytest.approx(two.bias[1:], abs=1e-4)


def test_gains_stay_in_their_ranges_and_at_25_hz(reference):
    q, r = reference
    net = shaken("full")
    controller = net.started(q, r)
    state = controller.start(q[0], r[0])
    gains = controller.gains(state, q[1], r[1], 0.04)
    assert (np.asarray(gains.kp) > 0).all()
    assert (np.asarray(gains.kp) < network.KP).all()
    assert np.abs(gains.bias).max() < network.BIAS * 1.5
    with pytest.raises(UnstableGainsError, match="25 Hz"):
        controller.gains(state, q[1], r[1], 0.01)


def test_variants_leave_out_what_they_say(reference):
    q, r = reference
    for variant in VARIANTS:
        net = shaken(variant)
        c = net.started(q, r)
        gains = c.gains(c.start(q[0], r[0]), q[1], r[1], 0.04)
        assert bool(np.any(gains.bias)) == (variant != "pd")
        assert bool(np.any(gains.ka)) == (variant == "full")
        assert net.integration == ("first-order" if variant in ("pd", "bias") else "exact")


def test_files_read_back_and_are_the_same_bytes(tmp_path):
    net = replace(shaken("s3"), note="two clips")
    write_gain_network_weights(net, tmp_path / "a.npz")
    write_gain_network_weights(net, tmp_path / "b.npz")
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    back = read_network(tmp_path / "a.npz")
    assert (back.variant, back.note, back.width) == ("s3", "two clips", 16)
    for name, values in net.weights.items():
        assert back.weights[name] == pytest.approx(values, rel=1e-3, abs=1e-6)


@pytest.mark.parametrize(
    ("change", "what"),
    [
        (lambda w: w.pop("control.w2"), "'control.w2'"),
        (lambda w: w.pop("control.b1"), "control"),
        (lambda w: w.update({"control.w3": np.zeros((3, 3), np.float32)}), "'control.w3'"),
        (lambda w: w["init.b3"].fill(np.nan), "'init.b3'"),
    ],
)
def test_files_that_are_no_network_are_refused(change, what, tmp_path):
    weights = {k: v.copy() for k, v in shaken("full").weights.items()}
    change(weights)
    write_gain_network_weights(Network(weights, "full"), tmp_path / "bad.npz")
    with pytest.raises(FormatError, match=what) as caught:
        read_network(tmp_path / "bad.npz")
    assert "\n" not in str(caught.value)


def test_other_files_are_refused(tmp_path):
    (tmp_path / "text.npz").write_text("weights")
    with pytest.raises(FormatError, match=r"\.npz"):
        read_network(tmp_path / "text.npz")
    write_gain_network_weights(Network(shaken("full").weights, "other"), tmp_path / "other.npz")
    with pytest.raises(FormatError, match="'other'"):
        read_network(tmp_path / "other.npz")


def test_an_epoch_of_windows_is_seeded_and_mirrored():
    s = read_cmu_bvh_sequence(ASSETS / "dance.bvh")
    settings = TrainingSettings(window=40, batch=3)
    starts = [(0, start) for start in range(0, 50, 10)]
    first, again = (list(batches([s], starts, settings, 4)) for _ in range(2))
    assert (first[0].q_hat == again[0].q_hat).all()
    other = next(batches([s], starts, settings, 5))
    assert (first[0].q_hat != other.q_hat).any()
    left = {bool(next(batches([s], starts, settings, e)).offsets[0, 1, 0] > 0) for e in range(8)}
    assert left == {True}  # mirrored or not, the left hip lies on the left
    seen = {next(batches([s], starts, settings, e)).offsets[0, 18, 0].round(6) for e in range(8)}
    assert len(seen) == 2


RECORD = Path(__file__).with_name("quamo_torch.npz")


def by_torch(variant, q, r):
    """Poses (60, 24, 4) and root places (60, 3) by the model that is trained."""
    torch = import_torch()
    weights = {k: torch.tensor(v) for k, v in shaken(variant).weights.items()}
    found = track_windows(
        torch, weights, q[None, :60], r[None, :60], make_torch_tracking_step(torch, variant)
    )
    return found[0][0].numpy(), found[1][0].numpy()


@pytest.mark.parametrize("variant", VARIANTS)
def test_numpy_is_torch_as_recorded(variant, reference):
    """Without PyTorch: what it once said, kept by running this file as a program."""
    q, r = reference
    ours = run(shaken(variant), q[:60], r[:60])
    with np.load(RECORD) as theirs:
        assert np.abs(ours.q - theirs[f"{variant}_q"]).max() <= 1e-5
        assert np.abs(ours.r - theirs[f"{variant}_r"]).max() <= 1e-5


@needs_torch
@pytest.mark.parametrize("variant", VARIANTS)
def test_numpy_is_torch(variant, reference):
    q, r = reference
    ours = run(shaken(variant), q[:60], r[:60])
    their_q, their_r = by_torch(variant, q, r)
    assert np.abs(ours.q - their_q).max() <= 1e-5
    assert np.abs(ours.r - their_r).max() <= 1e-5


@needs_torch
def test_training_lowers_the_loss_and_resumes_as_if_never_stopped(tmp_path):
    s = read_cmu_bvh_sequence(ASSETS / "dance.bvh")
    short = TrainingSettings(epochs=4, width=8, init_width=4, window=30, batch=4)
    told: list[str] = []
    whole = train([s], short, tell=told.append)
    losses = [float(t.split("loss ")[1].split(",")[0]) for t in told]
    assert len(losses) == 4
    assert min(losses[2:]) < losses[0] * 1.5
    point = tmp_path / "x.checkpoint"

    class StopError(Exception):
        pass

    def stop(text):
        if text.startswith("epoch 2/"):
            raise StopError

    with pytest.raises(StopError):
        train([s], short, point, tell=stop)
    resumed = train([s], short, point, tell=lambda _: None)
    for name, values in whole.weights.items():
        assert (resumed.weights[name] == values).all()
    with pytest.raises(TwistError, match="other settings"):
        train([s], replace(short, seed=1), point)


@needs_torch
def test_clips_too_short_for_a_window_are_refused():
    with pytest.raises(TwistError, match="at least 100 frames"):
        train([read_cmu_bvh_sequence(ASSETS / "walk.bvh")], TrainingSettings())


if __name__ == "__main__":
    found = {variant: by_torch(variant, *dance()) for variant in VARIANTS}
    np.savez_compressed(
        RECORD,
        **{
            f"{v}_{k}": part.astype(np.float32)
            for v, f in found.items()
            for k, part in zip("qr", f, strict=True)
        },
    )
