"""A camera that orbits a point and stays upright, with projection, presets and view directions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from twistcore.skeleton.rotation import Array, normalise

VIEW_ANGLE = np.radians(28.0)  # vertical field of view
_STEEPEST = np.radians(89.0)
# Tilts of the view along a bone; the best one comes first
_TILTS = np.array([-0.65, 0.65, -0.4, 0.4, -0.9, 0.9])
_HIDDEN = 6.0  # weight of the share of a limb that is hidden
_SLANT = 0.6  # best cosine of the angle between the limb's line and the view
VIEWS = {  # degrees around the figure from its front, and degrees above the horizon
    "front": (0.0, 4.0),
    "side": (90.0, 4.0),
    "back": (180.0, 4.0),
    "top": (0.0, 89.0),
    "iso": (32.0, 14.0),
}


@dataclass(frozen=True, eq=False)
class OrbitCamera:
    """An orbiting camera.

    Attributes
    ----------
    target
        The centre of the view, (3,).
    azimuth, elevation
        The angles of the camera around the target and above the horizon, in radians.
    distance
        The distance from the target in the unit of the file.
    up, ahead
        Orthogonal unit vectors, (3,). `ahead` is the direction of azimuth 0.
    """

    target: Array
    azimuth: float
    elevation: float
    distance: float
    up: Array
    ahead: Array

    @cached_property
    def direction(self) -> Array:
        """The unit vector from the target to the camera, (3,)."""
        level = np.cos(self.azimuth) * self.ahead + np.sin(self.azimuth) * self.sideways
        towards: Array = np.cos(self.elevation) * level + np.sin(self.elevation) * self.up
        return towards

    @cached_property
    def sideways(self) -> Array:
        """The horizontal unit vector at azimuth 90°, (3,)."""
        return np.cross(self.up, self.ahead)

    @cached_property
    def position(self) -> Array:
        """The position of the camera, (3,)."""
        return self.target + self.distance * self.direction

    @cached_property
    def axes(self) -> Array:
        """The directions right, up and backward in the image, as rows of a rotation matrix."""
        back = self.direction
        right = normalise(np.cross(self.up, back))
        return np.stack([right, np.cross(back, right), back])

    def orbited(self, azimuth: float, elevation: float) -> OrbitCamera:
        """Return a copy of the camera, rotated about its target by two angles in radians.

        The elevation is limited so that the camera is never upside down.
        """
        steep = float(np.clip(self.elevation + elevation, -_STEEPEST, _STEEPEST))
        return replace(self, azimuth=self.azimuth + azimuth, elevation=steep)

    def panned(self, right: float, up: float, height: int) -> OrbitCamera:
        """Return a copy of the camera, moved so that the image shifts by `right` and `up` pixels.

        `height` is the height of the image in pixels.
        """
        unit = 2.0 * self.distance * np.tan(VIEW_ANGLE / 2.0) / max(height, 1)
        axes = self.axes
        return replace(self, target=self.target - unit * (right * axes[0] + up * axes[1]))

    def moved(self, step: Array) -> OrbitCamera:
        """Return a copy of the camera, moved by a vector (3,) in world coordinates."""
        return self._placed(self.target + step, self.distance)

    def zoomed(self, factor: float) -> OrbitCamera:
        """Return a copy of the camera with its distance from the target divided by `factor`."""
        return replace(self, distance=self.distance / factor)

    def looking_from(self, direction: Array) -> OrbitCamera:
        """Return a copy of the camera that sees the target from a direction, a unit vector (3,)."""
        azimuth = np.arctan2(direction @ self.sideways, direction @ self.ahead)
        elevation = np.arcsin(np.clip(direction @ self.up, -1.0, 1.0))
        return replace(self, azimuth=float(azimuth), elevation=float(elevation)).orbited(0.0, 0.0)

    def framing(
        self, points: Array, aspect: float, margin: float = 1.12, covered: float = 0.0
    ) -> OrbitCamera:
        """Return a copy of the camera, moved so that the points (n, 3) fill the image.

        The camera is not rotated.
        `aspect` is the width of the image divided by its height, `margin` scales the distance, and
        `covered` is the share of the image's height that is covered at the top.
        """
        flat = points @ self.axes.T
        low, high = flat.min(axis=0), flat.max(axis=0)
        centre = (low + high) / 2.0
        tall = (high[1] - low[1]) / (1.0 - covered)
        size = max(tall, (high[0] - low[0]) / max(aspect, 0.1))
        centre[1] += covered * margin * size / 2.0
        away = margin * size / (2.0 * np.tan(VIEW_ANGLE / 2.0)) + (high[2] - low[2]) / 2.0
        return self._placed(centre @ self.axes, float(max(away, 1e-9)))

    def _placed(self, target: Array, distance: float) -> OrbitCamera:
        """Return a copy of the camera with a new target and distance.

        The cached directions are reused, because they do not depend on the target or the distance.
        """
        camera = replace(self, target=target, distance=distance)
        for name in ("sideways", "direction", "axes"):
            if name in vars(self):
                vars(camera)[name] = vars(self)[name]
        return camera

    def project(self, points: Array, width: int, height: int) -> tuple[Array, Array]:
        """Project points (…, 3) to pixels (…, 2), and return the pixels and the depths (…).

        `width` and `height` are the size of the image in pixels. The y axis of the image points
        down.
        """
        seen = (points - self.position) @ self.axes.T
        depth = np.maximum(-seen[..., 2], 1e-9 * self.distance)
        scale = height / (2.0 * np.tan(VIEW_ANGLE / 2.0)) / depth
        x = width / 2.0 + seen[..., 0] * scale
        y = height / 2.0 - seen[..., 1] * scale
        return np.stack([x, y], axis=-1), depth

    def ray(self, at: Array, width: int, height: int) -> Array:
        """Return the unit vector (3,) from the camera through a pixel (2,)."""
        unit = 2.0 * np.tan(VIEW_ANGLE / 2.0) / height
        seen = np.array([(at[0] - width / 2.0) * unit, (height / 2.0 - at[1]) * unit, -1.0])
        return normalise(seen @ self.axes)


def interpolate_cameras(start: OrbitCamera, stop: OrbitCamera, share: float) -> OrbitCamera:
    """Interpolate between two cameras that have the same `up` and `ahead`.

    `share` is 0 at `start` and 1 at `stop`. The azimuth changes in the direction of the shorter
    rotation.
    """
    turn = (stop.azimuth - start.azimuth + np.pi) % (2.0 * np.pi) - np.pi
    return replace(
        stop,
        target=start.target + share * (stop.target - start.target),
        azimuth=stop.azimuth - (1.0 - share) * float(turn),
        elevation=start.elevation + share * (stop.elevation - start.elevation),
        distance=start.distance ** (1.0 - share) * stop.distance**share,
    )


def rotate_to_named_view(camera: OrbitCamera, name: str, facing: Array) -> OrbitCamera:
    """Return a copy of the camera, rotated to the view `name` in VIEWS.

    `facing` is the horizontal direction in which the figure faces, (3,).
    """
    around, above = VIEWS[name]
    turned = replace(camera, ahead=facing, azimuth=np.radians(around), elevation=np.radians(above))
    return turned.orbited(0.0, 0.0)


# Returns the hidden share of a limb, (n,), for each direction, (n, 3)
Hidden = Callable[[Array], Array]


def _nothing_hidden(directions: Array) -> Array:
    return np.zeros(len(directions))


def roll_viewing_direction(
    axis: Array,
    after: Array,
    before: Array,
    outward: Array,
    facing: Array,
    up: Array,
    hidden: Hidden = _nothing_hidden,
) -> Array:
    """Return the best direction for viewing the roll of a bone, a unit vector (3,).

    The best view shows the whole limb from outside and not from below. The captured and the
    corrected front of the bone are both visible, and the view is at an angle to the bone, so that a
    circle about the bone looks open. All vectors are (3,).

    Parameters
    ----------
    axis
        The unit vector along the bone.
    after, before
        The corrected and the captured normal of the bone's front.
    outward
        A vector from the body to the limb.
    facing
        The direction in which the figure faces.
    up
        The upward direction.
    hidden
        A function that returns the hidden share of the limb for each direction.
    """
    first = np.cross(axis, up)
    if np.linalg.norm(first) < 0.1:
        first = np.cross(axis, facing)
    first = normalise(first)
    second = np.cross(axis, first)
    turns = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)[:, None]
    across = np.cos(turns) * first + np.sin(turns) * second
    tilts = np.repeat(_TILTS, len(turns))
    seen = np.tile(across, (len(_TILTS), 1)) + tilts[:, None] * axis
    seen /= np.linalg.norm(seen, axis=1, keepdims=True)
    full, other = seen @ after, seen @ before
    level = seen @ up
    between = after + before
    between /= max(float(np.linalg.norm(between)), 0.5)  # opposite fronts have no middle
    score = (
        1.6 * np.minimum(np.minimum(full, other), 0.6)
        + 0.4 * np.maximum(full, other)
        + 0.5 * (seen @ between)
        + 0.9 * (seen @ outward)
        + 0.3 * (seen @ facing)
        - 2.0 * np.maximum(-0.05 - level, 0.0)
        - 1.5 * np.maximum(level - 0.6, 0.0)
        - 2.0 * np.abs(np.abs(tilts) - _TILTS[1])
    )
    seen = normalise(seen + 0.05 * up)
    best: Array = seen[int(np.argmax(score - _HIDDEN * hidden(seen)))]
    return best


def circle_viewing_direction(
    axis: Array,
    aside: Array,
    outward: Array,
    facing: Array,
    up: Array,
    hidden: Hidden = _nothing_hidden,
) -> Array:
    """Return the best direction for viewing a rotation about a limb's line, a unit vector (3,).

    The line leads from the limb's first joint to its end. The best view is at an angle to the line,
    so the circle of the middle joint looks open. It shows the whole limb, with the middle joint to
    one side, and is neither from below nor from far above. All vectors are (3,).

    Parameters
    ----------
    axis
        The unit vector along the limb's line.
    aside
        A vector from the line to the middle joint.
    outward
        A vector from the body to the limb.
    facing
        The direction in which the figure faces.
    up
        The upward direction.
    hidden
        A function that returns the hidden share of the limb for each direction.
    """
    around, above = np.meshgrid(np.radians(np.arange(0, 360, 10)), np.radians(np.arange(0, 45, 9)))
    side = np.cross(up, facing)
    level = np.cos(around)[..., None] * facing + np.sin(around)[..., None] * side
    seen = (np.cos(above)[..., None] * level + np.sin(above)[..., None] * up).reshape(-1, 3)
    along, across = np.abs(seen @ axis), np.abs(seen @ normalise(aside))
    beside = outward - (outward @ up) * up
    score = (
        -2.0 * np.abs(along - _SLANT)
        - 1.5 * across
        + 0.6 * (seen @ beside) / max(float(np.linalg.norm(beside)), 1e-9)
        + 0.3 * (seen @ facing)
        - 0.5 * (seen @ up)
        - _HIDDEN * hidden(seen)
    )
    best: Array = seen[int(np.argmax(score))]
    return best
