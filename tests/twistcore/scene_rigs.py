"""Scenes in which a clip plays on a rig with axes of its own, as Maya and MotionBuilder show them.

Only what the scripts ask for is there, by the programs' documented words; what is called is noted.
"""

from types import SimpleNamespace

import numpy as np

from twistcore.skeleton.rotation import (
    conjugate,
    euler_from_quaternion,
    matrix_from_quaternion,
    multiply,
    normalise,
    quaternion_from_euler,
    rotate,
)

ORDERS = ("XYZ", "YZX", "ZXY", "XZY", "YXZ", "ZYX")
ONE = np.array([1.0, 0.0, 0.0, 0.0])


def random_rotations(count, seed):
    return normalise(np.random.default_rng(seed).normal(size=(count, 4)))


class Rig:
    """A clip's skeleton with turned axes: rotation = front · channels · behind.

    Angles X, Y, Z in degrees by joint and frame of the scene; between keys linear, as are the
    places. The world is turned and scaled.
    """

    def __init__(self, motion, seed=0, behind=True, start=0, step=1.0, prefix=""):
        self.names = [prefix + name for name in motion.skeleton.names]
        self.parents = motion.skeleton.parents.tolist()
        joints = len(self.names)
        axes = random_rotations(joints, seed)
        self.front = random_rotations(joints, seed + 1)
        twice = np.random.default_rng(seed + 2)
        self.behind_degrees = twice.uniform(-80, 80, (joints, 3)) * behind
        self.behind = quaternion_from_euler("ZYX", np.radians(self.behind_degrees[:, ::-1]))
        self.order = [ORDERS[k % 6] for k in range(joints)]
        self.above = random_rotations(1, seed + 3)[0]
        self.scale = 0.37
        self.frames = start + step * np.arange(motion.frames)
        self.frame_numbers = {frame: k for k, frame in enumerate(self.frames.tolist())}
        self.curves, self.places, self.known = [], [], {}
        for joint, parent in enumerate(self.parents):
            up = axes[parent] if parent >= 0 else ONE
            seen = multiply(multiply(conjugate(up), motion.rotations[:, joint]), axes[joint])
            own = multiply(
                conjugate(self.front[joint]), multiply(seen, conjugate(self.behind[joint]))
            )
            angles = euler_from_quaternion(self.order[joint][::-1], own)[:, ::-1]
            degrees = np.empty((motion.frames, 3))
            degrees[:, ["XYZ".index(c) for c in self.order[joint]]] = np.degrees(
                np.unwrap(angles, axis=0)
            )
            self.curves.append(
                [
                    dict(zip(self.frames.tolist(), degrees[:, k].tolist(), strict=True))
                    for k in range(3)
                ]
            )
            place = np.broadcast_to(motion.translation(joint), (motion.frames, 3))
            self.places.append(self.scale * rotate(conjugate(up), place))

    def index(self, name):
        return self.names.index(name)

    def value(self, joint, axis, frame):
        curve = self.curves[joint][axis]
        if frame in curve:
            return curve[frame]
        at = sorted(curve)
        return float(np.interp(frame, at, [curve[f] for f in at]))

    def local(self, joint, frame):
        values = [self.value(joint, axis, frame) for axis in range(3)]
        order = self.order[joint]
        angles = np.radians([values["XYZ".index(c)] for c in order])
        own = quaternion_from_euler(order[::-1], angles[::-1])
        return multiply(self.front[joint], multiply(own, self.behind[joint]))

    def world(self, joint, frame):
        """Rotation and place."""
        if joint < 0:
            return self.above, np.array([5.0, -2.0, 1.0])
        if (joint, frame) in self.known:
            return self.known[joint, frame]
        rotation, place = self.world(self.parents[joint], frame)
        at = self.frame_numbers.get(frame)
        if at is None:
            offset = [np.interp(frame, self.frames, c) for c in self.places[joint].T]
        else:
            offset = self.places[joint][at]
        found = multiply(rotation, self.local(joint, frame)), place + rotate(rotation, offset)
        self.known[joint, frame] = found
        return found

    def matrix(self, joint, frame):
        """16 numbers of row vectors, the place in 12-14."""
        rotation, place = self.world(joint, frame)
        m = np.eye(4)
        m[:3, :3], m[3, :3] = matrix_from_quaternion(rotation).T, place
        return m.ravel().tolist()

    def put(self, joint, axis, frame, value):
        self.curves[joint][axis][frame] = value
        self.known.clear()


class Cmds:
    """maya.cmds, in degrees or radians."""

    def __init__(self, rig, time="120fps", angle="deg"):
        self.rig, self.unit_of_time, self.angle, self.called = rig, time, angle, []
        self.locked = ()

    def currentTime(self, query):  # noqa: N802
        return 3.0

    def currentUnit(self, query, angle=False, time=False):  # noqa: N802
        return self.angle if angle else self.unit_of_time

    def ls(self, name, type, long):
        return ["|group|" + name] if name in self.rig.names else []

    def _of(self, degrees):
        return degrees if self.angle == "deg" else np.radians(degrees)

    def getAttr(self, plug, time=None, lock=False):  # noqa: N802
        node, attribute = plug.rsplit("|", 1)[1].split(".")
        joint = self.rig.index(node)
        if lock:
            return plug in self.locked
        if attribute == "worldMatrix[0]":
            return self.rig.matrix(joint, time)
        if attribute == "parentMatrix[0]":
            return self.rig.matrix(self.rig.parents[joint], time)
        if attribute == "rotateOrder":
            return ORDERS.index(self.rig.order[joint])
        if attribute.startswith("rotateAxis"):
            return self._of(self.rig.behind_degrees[joint]["XYZ".index(attribute[-1])])
        return self._of(self.rig.value(joint, "XYZ".index(attribute[-1]), time))

    def setKeyframe(self, node, attribute, time, value=None, insert=False, **tangents):  # noqa: N802
        joint, axis = self.rig.index(node.rsplit("|", 1)[1]), "XYZ".index(attribute[-1])
        self.called.append(("insert" if insert else "key", self.rig.names[joint], time))
        if insert:
            self.rig.put(joint, axis, time, self.rig.value(joint, axis, time))
            return
        self.rig.put(joint, axis, time, value if self.angle == "deg" else np.degrees(value))

    def undoInfo(self, **words):  # noqa: N802
        self.called.append(("undo", *words))

    def modules(self):
        return {"maya": SimpleNamespace(cmds=self), "maya.cmds": self}


class Sdk:
    """pyfbsdk."""

    class FBModelTransformationType:
        kModelTransformation = 1  # noqa: N815

    FBModelRotationOrder = SimpleNamespace(**{"kFBEuler" + order: order for order in ORDERS})

    class FBTime:
        def SetSecondDouble(self, seconds):  # noqa: N802
            self.seconds = seconds

        def GetSecondDouble(self):  # noqa: N802
            return self.seconds

    class FBMatrix(list):
        pass

    def __init__(self, rig, fps=120.0, takes=("Take 001", "walk")):
        self.rig, self.fps, self.called = rig, fps, []
        self.player = SimpleNamespace(GetTransportFpsValue=lambda: self.fps, Goto=self._goto)
        scene = SimpleNamespace(
            Takes=[SimpleNamespace(Name=name) for name in takes], Evaluate=lambda: True
        )
        local = self.FBTime()
        local.SetSecondDouble(0.025)
        self.system = SimpleNamespace(Scene=scene, CurrentTake=scene.Takes[0], LocalTime=local)
        self.models = [self._model(joint) for joint in range(len(rig.names))]
        self._goto(local)

    def _goto(self, time):
        self.frame = self._frame(time)

    def _frame(self, time):
        return round(time.seconds * self.fps, 6)

    def _model(self, joint):
        curves = [
            SimpleNamespace(
                Evaluate=lambda time, axis=axis: self.rig.value(joint, axis, self._frame(time)),
                KeyAdd=lambda time, value, axis=axis: self._key(joint, axis, time, value),
            )
            for axis in range(3)
        ]
        node = SimpleNamespace(Nodes=[SimpleNamespace(FCurve=curve) for curve in curves])
        # in MotionBuilder what stands behind is the inverse of the post-rotation
        turned = conjugate(self.rig.behind[joint])
        post = np.degrees(euler_from_quaternion("ZYX", turned))[::-1]

        def get_matrix(matrix, what, everywhere):
            matrix[:] = self.rig.matrix(joint, self.frame)

        return SimpleNamespace(
            Parent=None,
            GetMatrix=get_matrix,
            RotationActive=True,
            RotationOrder=self.rig.order[joint],
            PostRotation=post.tolist(),
            Rotation=SimpleNamespace(GetAnimationNode=lambda: node, SetAnimated=lambda _: True),
        )

    def _key(self, joint, axis, time, value):
        self.called.append((self.rig.names[joint], self._frame(time)))
        self.rig.put(joint, axis, self._frame(time), value)

    def FBSystem(self):  # noqa: N802
        return self.system

    def FBPlayerControl(self):  # noqa: N802
        return self.player

    def FBFindModelByLabelName(self, name):  # noqa: N802
        if name not in self.rig.names:
            return None
        joint = self.rig.index(name)
        above, model = self.rig.parents[joint], self.models[joint]
        if above >= 0:
            model.Parent = self.models[above]
        else:
            model.Parent = SimpleNamespace(
                GetMatrix=lambda m, *_: m.__setitem__(slice(None), self.rig.matrix(-1, self.frame))
            )
        return model

    def FBUndoManager(self):  # noqa: N802
        return SimpleNamespace(
            TransactionBegin=lambda _: self.called.append("begin"),
            TransactionAddModelTRS=lambda _: self.called.append("model"),
            TransactionEnd=lambda: self.called.append("end"),
        )

    def modules(self):
        return {"pyfbsdk": self}
