"""Runs in a Python that has bpy, without this project: makes scenes, runs scripts in them, looks.

JOBS.json, the last word, is a list of [what, …words], done one after the other.
"""

import contextlib
import json
import os
import sys
import time
import traceback
from pathlib import Path

import bpy
import numpy as np


def empty():
    bpy.ops.wm.read_factory_settings(use_empty=True)


def bvh(path, mode="NATIVE", scale=1.0, start=1):
    bpy.ops.import_anim.bvh(
        filepath=path,
        rotate_mode=mode,
        frame_start=start,
        update_scene_fps=True,
        global_scale=scale,
    )


def to_fbx(path, simplify=0.0):
    bpy.ops.export_scene.fbx(
        filepath=path, add_leaf_bones=False, bake_anim_simplify_factor=simplify
    )


def fbx(path):
    bpy.ops.import_scene.fbx(filepath=path)


def to_glb(path):
    bpy.ops.export_scene.gltf(filepath=path)


def save(path):
    bpy.ops.wm.save_as_mainfile(filepath=path)


def second_take(name):
    """A copy of the action in which nothing turns from frame 100 on."""
    data = rig().animation_data
    action = data.action.copy()
    action.name, action.use_fake_user = name, True
    for curve in action.layers[0].strips[0].channelbags[0].fcurves:
        held = curve.evaluate(100)
        for key in curve.keyframe_points:
            key.co[1] = key.co[1] if key.co[0] < 100 else held


def rig():
    """The active armature, or the first."""
    active = bpy.context.view_layer.objects.active
    rigs = [o for o in bpy.data.objects if o.type == "ARMATURE"]
    return active if active in rigs else rigs[0]


def activate(name):
    bpy.context.view_layer.objects.active = bpy.data.objects[name]


def addon(path, **programs):
    """Install an add-on for this user, and set its preferences."""
    bpy.ops.preferences.addon_install(filepath=path, overwrite=True)
    name = Path(path).stem
    bpy.ops.preferences.addon_enable(module=name)
    for which, program in programs.items():
        setattr(bpy.context.preferences.addons[name].preferences, which, program)


def click(operator, **words):
    """Run an operator of the add-on; Blender prints its reports."""
    with contextlib.suppress(RuntimeError):  # what is reported as an error, too
        getattr(bpy.ops.twist_inspector, operator)(**words)


def wait(path):
    end = time.monotonic() + 60.0
    while not Path(path).exists() and time.monotonic() < end:
        time.sleep(0.05)


def turn(degrees, scale):
    """The figure somewhere else in the room, under a parent."""
    empty = bpy.data.objects.new("above", None)
    bpy.context.scene.collection.objects.link(empty)
    empty.rotation_euler = [np.radians(degrees)] * 3
    empty.location, empty.scale = (1.0, 2.0, 3.0), [scale] * 3
    rig().parent = empty


def rename(old, new):
    rig().pose.bones[old].name = new


def rename_all(names, action):
    """Other names for all bones, in their order, and for the action; Blender must take each."""
    figure = rig()
    for bone, name in zip(list(figure.pose.bones), names, strict=True):
        bone.name = name
        assert bone.name == name, (bone.name, name)
    figure.animation_data.action.name = action
    assert figure.animation_data.action.name == action


def constrain(bone, target):
    constraint = rig().pose.bones[bone].constraints.new("COPY_ROTATION")
    constraint.target, constraint.subtarget = rig(), target


def shift_keys(by):
    data = rig().animation_data
    for curve in data.action.layers[0].strips[0].channelbag(data.action_slot).fcurves:
        for key in curve.keyframe_points:
            key.co[0] += by


def smooth():
    """Curves as an animator has them, with handles that see to themselves."""
    data = rig().animation_data
    for curve in data.action.layers[0].strips[0].channelbag(data.action_slot).fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "BEZIER"
            key.handle_left_type = key.handle_right_type = "AUTO_CLAMPED"
        curve.update()


def look(path, frames, first=1.0, step=1.0):
    """World matrices of all bones and of the rest pose, and how many keys there are."""
    scene, figure = bpy.context.scene, rig()
    bones = list(figure.pose.bones)
    poses, sides = np.zeros((frames, len(bones), 4, 4)), np.zeros((frames, len(bones), 4))
    for frame in range(frames):
        at = first + frame * step
        scene.frame_set(int(at // 1), subframe=at % 1)
        for k, bone in enumerate(bones):
            poses[frame, k] = figure.matrix_world @ bone.matrix
            sides[frame, k] = bone.rotation_quaternion
    rest = np.array([figure.matrix_world @ b.bone.matrix_local for b in bones])
    data = figure.animation_data
    curves = data.action.layers[0].strips[0].channelbag(data.action_slot).fcurves
    keys = {}
    for curve in curves:
        keys.setdefault(curve.data_path, []).append(len(curve.keyframe_points))
    names = [b.name for b in bones]
    np.savez(path, names=names, poses=poses, rest=rest, sides=sides, keys=json.dumps(keys))


def script(path):
    with open(path, encoding="utf-8") as file:  # noqa: PTH123 - nothing but bpy's Python here
        text = file.read()
    try:
        exec(compile(text, path, "exec"), {"__name__": "__main__"})
    except RuntimeError as error:
        print(f"refused: {error}")


def main():
    with open(sys.argv[-1], encoding="utf-8") as file:  # noqa: PTH123
        jobs = json.load(file)
    code = 0
    try:
        for what, *words in jobs:
            named = words.pop() if words and isinstance(words[-1], dict) else {}
            printed = sys.stdout if what in ("script", "click") else sys.stderr
            with contextlib.redirect_stdout(printed):
                globals()[what](*words, **named)
    except Exception:
        traceback.print_exc()
        code = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # Blender's own clean-up may crash as a module, long after the result


main()
