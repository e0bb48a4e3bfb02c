"""Unit quaternions: products, Euler angles, swing and twist.

Quaternions are Hamilton quaternions with the scalar first, ``(w, x, y, z)``. They act on column
vectors and compose like matrices, so ``multiply(p, q)`` rotates by q first and then by p. Angles
are in radians. Leading axes, written as …, broadcast.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array: TypeAlias = NDArray[np.float64]

_AXIS_INDEX = {"X": 0, "Y": 1, "Z": 2}


def wrap(angle: ArrayLike) -> Array:
    """Wrap angles into (−π, π] by adding full turns. The shape does not change."""
    a = np.asarray(angle, dtype=np.float64)
    if a.size < 64:
        return _wrap(a)
    wrapped = a.copy()
    outside = np.abs(a) >= np.pi  # usually few angles; wrapping all of them takes 8 times as long
    if outside.any():
        wrapped[outside] = _wrap(a[outside])
    return wrapped


def largest_and_rms_angle_degrees(angles: ArrayLike) -> tuple[float, float]:
    """Return the maximum and the root mean square of the magnitudes of wrapped angles, in degrees.

    `angles` are in radians, shape (n,). The result is (0, 0) if there are none.
    """
    sizes = np.degrees(np.abs(wrap(angles)))
    if not sizes.size:
        return 0.0, 0.0
    return float(sizes.max()), float(np.sqrt(np.mean(sizes**2)))


def _wrap(a: Array) -> Array:
    wrapped: Array = a - 2.0 * np.pi * np.ceil((a - np.pi) / (2.0 * np.pi))
    return wrapped


def multiply(p: ArrayLike, q: ArrayLike) -> Array:
    """Return the Hamilton product p ⊗ q of quaternions, shape (…, 4)."""
    # Products of complex numbers would be faster, but numpy rounds them as the processor can, and
    # q⁻¹ q would not be exactly 1.
    p, q = np.asarray(p, dtype=np.float64), np.asarray(q, dtype=np.float64)
    pw, px, py, pz = (p[..., i] for i in range(4))
    qw, qx, qy, qz = (q[..., i] for i in range(4))
    out = np.empty((*np.broadcast_shapes(p.shape[:-1], q.shape[:-1]), 4))
    out[..., 0] = pw * qw - px * qx - py * qy - pz * qz
    out[..., 1] = pw * qx + px * qw + py * qz - pz * qy
    out[..., 2] = pw * qy - px * qz + py * qw + pz * qx
    out[..., 3] = pw * qz + px * qy - py * qx + pz * qw
    return out


def conjugate(q: ArrayLike) -> Array:
    """Return the inverse of unit quaternions, shape (…, 4)."""
    q = np.asarray(q, dtype=np.float64)
    inverse: Array = -q
    inverse[..., 0] = q[..., 0]
    return inverse


def rotate(q: ArrayLike, v: ArrayLike) -> Array:
    """Rotate vectors v, shape (…, 3), by unit quaternions q, shape (…, 4)."""
    q, v = np.asarray(q, dtype=np.float64), np.asarray(v, dtype=np.float64)
    w, x, y, z = (q[..., i] for i in range(4))
    # np.cross would be several times slower for the few joints of one frame.
    a, b, c = (v[..., i] for i in range(3))
    tx, ty, tz = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    out = np.empty((*np.broadcast_shapes(q.shape[:-1], v.shape[:-1]), 3))
    out[..., 0] = a + w * tx + (y * tz - z * ty)
    out[..., 1] = b + w * ty + (z * tx - x * tz)
    out[..., 2] = c + w * tz + (x * ty - y * tx)
    return out


def cross_products(u: ArrayLike, v: ArrayLike) -> Array:
    """Return the cross product u × v of vectors (…, 3). Faster than np.cross."""
    u, v = np.asarray(u, dtype=np.float64), np.asarray(v, dtype=np.float64)
    a, b, c = (u[..., i] for i in range(3))
    x, y, z = (v[..., i] for i in range(3))
    out = np.empty((*np.broadcast_shapes(a.shape, x.shape), 3))
    out[..., 0] = b * z - c * y
    out[..., 1] = c * x - a * z
    out[..., 2] = a * y - b * x
    return out


def vector_lengths(v: ArrayLike) -> Array:
    """Return the lengths of vectors or quaternions, (…, n) → (…). Far faster than np.linalg.norm.

    For n < 8 and 64-bit numbers, the results are the same, bit for bit. n must not be 0.
    """
    v = np.asarray(v, dtype=np.float64)
    squares = v[..., 0] * v[..., 0]
    for i in range(1, v.shape[-1]):
        squares = squares + v[..., i] * v[..., i]
    return np.asarray(np.sqrt(squares))


def normalise(v: ArrayLike) -> Array:
    """Scale vectors or quaternions to unit length along the last axis. No length may be 0."""
    v = np.asarray(v, dtype=np.float64)
    unit: Array = v / vector_lengths(v)[..., None]
    return unit


def continuous_quaternion_signs(q: ArrayLike) -> Array:
    """Choose the signs of quaternions, (frames, …, 4), that make them continuous over the frames.

    The rotations do not change.
    """
    q = np.asarray(q, dtype=np.float64)
    opposed = np.einsum("t...i,t...i->t...", q[:-1], q[1:]) < 0.0
    flips = np.zeros(q.shape[:-1], dtype=bool)
    flips[1:] = np.logical_xor.accumulate(opposed, axis=0)
    return np.where(flips[..., None], -q, q)


def quaternion_from_axis_angle(axis: ArrayLike, angle: ArrayLike) -> Array:
    """Return the rotations about unit axes (…, 3) by angles (…) as quaternions (…, 4)."""
    axis, half = np.asarray(axis, dtype=np.float64), 0.5 * np.asarray(angle, dtype=np.float64)
    shape = np.broadcast_shapes(axis.shape[:-1], half.shape)
    out = np.empty((*shape, 4))
    out[..., 0] = np.cos(half)
    out[..., 1:] = np.sin(half)[..., None] * axis
    return out


def exponential(rotation_vector: ArrayLike) -> Array:
    """Return the rotations with the given rotation vectors φ (…, 3) as quaternions (…, 4).

    Exp(φ) = (cos(|φ|/2), sin(|φ|/2) φ/|φ|) [Le26 Eq. 4].
    """
    phi = np.asarray(rotation_vector, dtype=np.float64)
    half = 0.5 * np.sqrt(np.einsum("...i,...i->...", phi, phi))
    out = np.empty((*phi.shape[:-1], 4))
    out[..., 0] = np.cos(half)
    # Unlike φ/|φ|, sinc is defined at |φ| = 0.
    out[..., 1:] = (0.5 * np.sinc(half / np.pi))[..., None] * phi
    return out


def logarithm(q: ArrayLike) -> Array:
    """Return the rotation vectors of quaternions (…, 4), shape (…, 3), with lengths in [0, π].

    This is the inverse of :func:`exponential`.
    """
    q = np.asarray(q, dtype=np.float64)
    q = np.where(q[..., :1] < 0.0, -q, q)
    sine = np.sqrt(np.einsum("...i,...i->...", q[..., 1:], q[..., 1:]))
    small = sine < 1e-12
    scale = np.where(small, 2.0, 2.0 * np.arctan2(sine, q[..., 0]) / np.where(small, 1.0, sine))
    vector: Array = scale[..., None] * q[..., 1:]
    return vector


def slerp(p: ArrayLike, q: ArrayLike, share: ArrayLike) -> Array:
    """Interpolate between unit quaternions p and q, (…, 4), on the shorter arc.

    `share` contains the fractions of the arc from p to q, in [0, 1], shape (…).
    """
    step = logarithm(multiply(q, conjugate(p)))
    return multiply(exponential(np.asarray(share)[..., None] * step), p)


def matrix_from_quaternion(q: ArrayLike) -> Array:
    """Return the rotation matrices (…, 3, 3) of unit quaternions (…, 4)."""
    q = np.asarray(q, dtype=np.float64)
    w, x, y, z = (q[..., i] for i in range(4))
    out = np.empty((*q.shape[:-1], 3, 3))
    out[..., 0, 0] = 1.0 - 2.0 * (y * y + z * z)
    out[..., 0, 1] = 2.0 * (x * y - w * z)
    out[..., 0, 2] = 2.0 * (x * z + w * y)
    out[..., 1, 0] = 2.0 * (x * y + w * z)
    out[..., 1, 1] = 1.0 - 2.0 * (x * x + z * z)
    out[..., 1, 2] = 2.0 * (y * z - w * x)
    out[..., 2, 0] = 2.0 * (x * z - w * y)
    out[..., 2, 1] = 2.0 * (y * z + w * x)
    out[..., 2, 2] = 1.0 - 2.0 * (x * x + y * y)
    return out


def quaternion_from_euler(order: str, angles: ArrayLike) -> Array:
    """Return the quaternions of intrinsic rotations about one to three axes, shape (…, 4).

    Parameters
    ----------
    order
        The axes, such as 'ZYX'. The rotations are multiplied in this order, R = R₁ · R₂ · R₃.
    angles
        Angles in radians, in the order of the axes, shape (…, number of axes).
    """
    angles = np.asarray(angles, dtype=np.float64)
    out = np.zeros((*angles.shape[:-1], 4))
    out[..., 0] = 1.0
    half = 0.5 * angles
    c, s = np.cos(half), np.sin(half)
    for k, letter in enumerate(order):
        # The product q ⊗ (cos, sin·e_i) needs 8 multiplications instead of 16, because two
        # components of its second factor are 0.
        i = _AXIS_INDEX[letter]
        j, m = (i + 1) % 3, (i + 2) % 3
        w, x, y, z = out[..., 0], out[..., 1 + i], out[..., 1 + j], out[..., 1 + m]
        ck, sk = c[..., k], s[..., k]
        w, x, y, z = w * ck - x * sk, x * ck + w * sk, y * ck + z * sk, z * ck - y * sk
        out[..., 0], out[..., 1 + i], out[..., 1 + j], out[..., 1 + m] = w, x, y, z
    return out


def euler_from_quaternion(order: str, q: ArrayLike) -> Array:
    """Return the angles of intrinsic rotations about three different axes, radians, shape (…, 3).

    The middle angle φ2 is in [−π/2, π/2]. The other solution is (φ1 + π, π − φ2, φ3 + π). In gimbal
    lock (cos φ2 ≈ 0), only φ1 ± φ3 is determined. Use :func:`euler_with_third_held` to choose φ3.

    Parameters
    ----------
    order
        The axes, such as 'ZYX', as in :func:`quaternion_from_euler`.
    q
        Unit quaternions, shape (…, 4).
    """
    i, j, k = (_AXIS_INDEX[letter] for letter in order)
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    m = matrix_from_quaternion(q)
    # Row i of R = R_i(φ1) R_j(φ2) R_k(φ3) is (cosφ2 cosφ3, −s cosφ2 sinφ3, s sinφ2) in the order
    # (i, j, k), where s is the sign.
    cos2 = np.hypot(m[..., i, i], m[..., i, j])
    out = np.empty((*m.shape[:-2], 3))
    out[..., 0] = np.arctan2(-sign * m[..., j, k], m[..., k, k])
    out[..., 1] = np.arctan2(sign * m[..., i, k], cos2)
    out[..., 2] = np.arctan2(-sign * m[..., i, j], m[..., i, i])
    return out


def euler_with_third_held(order: str, q: ArrayLike, third: ArrayLike) -> Array:
    """Return the Euler angles of quaternions q with the given third angles, radians, shape (…, 3).

    The result is exact in gimbal lock, where any third angle is possible.
    """
    third = np.asarray(third, dtype=np.float64)
    unwound = multiply(q, conjugate(quaternion_from_euler(order[2], third[..., None])))
    i, j, k = (_AXIS_INDEX[letter] for letter in order)
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    m = matrix_from_quaternion(unwound)
    out = np.empty((*m.shape[:-2], 3))
    # In the product R_i(φ1) R_j(φ2), column j is R_i e_j and row i is e_i R_j.
    out[..., 0] = np.arctan2(sign * m[..., k, j], m[..., j, j])
    out[..., 1] = np.arctan2(sign * m[..., i, k], m[..., i, i])
    out[..., 2] = third
    return out


def twist_angle(q: ArrayLike, axis: ArrayLike) -> Array:
    """Return the twist angle of rotations about a unit axis a, in (−π, π] [Choi26 Eq. 8].

    The angle of q = (w, v) is wrap(2·atan2(v·a, w)). Eq. 8 as printed uses the norm of v and so
    loses the sign. If a swing of exactly 180° leaves the twist undefined, the result is 0, never
    NaN (see :func:`twist_reliability`).

    Parameters
    ----------
    q
        Unit quaternions, shape (…, 4).
    axis
        Unit axis a, shape (…, 3).
    """
    q = np.asarray(q, dtype=np.float64)
    along = np.einsum("...i,...i->...", q[..., 1:], np.asarray(axis, dtype=np.float64))
    return wrap(2.0 * np.arctan2(along, q[..., 0]))


def twist_reliability(q: ArrayLike, axis: ArrayLike) -> Array:
    """Return how well the twist of a rotation is defined, in [0, 1].

    The value for q = (w, v) and the unit axis a is √(w² + (v·a)²). It is 0 if a swing of 180°
    leaves the twist undefined.
    """
    q = np.asarray(q, dtype=np.float64)
    along = np.einsum("...i,...i->...", q[..., 1:], np.asarray(axis, dtype=np.float64))
    reliability: Array = np.hypot(q[..., 0], along)
    return reliability


def swing_twist(q: ArrayLike, axis: ArrayLike) -> tuple[Array, Array]:
    """Split rotations into swing and twist: q = swing ⊗ twist [Choi26 Eq. 2-7].

    The twist is a rotation about the axis. The swing rotates the axis to the same direction as
    q does, by the smallest possible angle. Eq. 7 as printed, q ⊗ swing⁻¹, is a different
    quaternion: the rotation by the same angle about the rotated axis.

    Parameters
    ----------
    q : array_like, shape (..., 4)
        Unit quaternions (w, x, y, z).
    axis : array_like, shape (..., 3)
        Unit vectors (x, y, z).

    Returns
    -------
    swing, twist : ndarray, shape (..., 4)
        Unit quaternions (w, x, y, z). The twist is 1 where a swing of 180° leaves it undefined.

    Raises
    ------
    ValueError
        If the shapes do not broadcast.

    Examples
    --------
    >>> import numpy as np
    >>> import twistcore as tc
    >>> clip = tc.read_clip("assets/walk_injected.bvh")
    >>> chain = tc.find_chains(clip)[2]
    >>> q = clip.motion.rotations[:, chain.parent]
    >>> swing, twist = tc.swing_twist(q, chain.axis)
    >>> swing.shape, twist.shape
    ((344, 4), (344, 4))
    >>> bool(np.allclose(swing[:, 1:] @ chain.axis, 0.0))  # the swing has no twist
    True
    """
    twist = quaternion_from_axis_angle(axis, twist_angle(q, axis))
    return multiply(q, conjugate(twist)), twist


def geodesic_angle(p: ArrayLike, q: ArrayLike) -> Array:
    """Return the angle of the rotation from p to q, radians in [0, π], shape (…)."""
    d = multiply(conjugate(p), q)
    angle: Array = 2.0 * np.arctan2(vector_lengths(d[..., 1:]), np.abs(d[..., 0]))
    return angle
