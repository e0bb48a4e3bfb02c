"""Blender add-on: review the active action in Twist Inspector, and set keys for the decisions.

Install this file with Edit → Preferences → Add-ons → Install from Disk. Its tab Twist is in the 3D
view's sidebar (N). If Twist Inspector is not on the path, choose its programs in the preferences.
"""

import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import namedtuple
from pathlib import Path

import bpy

bl_info = {
    "name": "Twist Inspector",
    "description": "Review the active action in Twist Inspector, and set keys for the decisions",
    "author": "Twist Inspector developers",
    "version": (1, 0, 0),
    "blender": (4, 2, 0),
    "location": "3D View → Sidebar → Twist",
    "category": "Animation",
}
WATCHED = 3.0  # seconds in which an error at the start of the window is reported


class RefusedError(Exception):
    """One sentence for the user."""


# `start` and `fps`: the scene's frame at the clip's first frame, and the scene's frame rate
Take = namedtuple("Take", "armature action clip start fps")


def clip_path(blend, armature, action):
    """Return a BVH next to the .blend that belongs to one action of one armature."""
    names = (re.sub(r"[^\w-]", lambda c: f"%{ord(c[0]):02x}", n) for n in (armature, action))
    return Path(blend).with_name(".".join((Path(blend).stem, *names, "bvh")))


def session_path(clip):
    """Return the file in which Twist Inspector saves the decisions on a BVH."""
    return clip.with_suffix(".twist.json")


def convert_command(twistcore, blend, take, blender):
    """Return the command that writes the take's BVH from a .blend. '=' allows names like '-a'."""
    names = f"--armature={take.armature}", f"--take={take.action}", f"--blender={blender}"
    return [twistcore, "convert", str(blend), "-o", str(take.clip), *names]


def export_command(twistcore, take, script, dry_run):
    """Return the command that writes the accepted corrections as a script for Blender."""
    command = [twistcore, "export", str(session_path(take.clip)), str(take.clip)]
    command += ["--script", "blender", "-o", str(script), f"--take={take.action}"]
    command += [f"--start={take.start!r}", f"--fps={take.fps!r}"]
    return [*command, "--dry-run"] if dry_run else command


def run(command, seconds=math.inf):
    """Run a program; yield until it ends or the time is over. Returns exit code and messages."""
    utf8 = {**os.environ, "PYTHONIOENCODING": "utf-8"}
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as output:
        quiet = {"stdin": subprocess.DEVNULL, "stdout": output, "stderr": output}
        process = subprocess.Popen(command, env=utf8, start_new_session=True, **quiet)
        end = time.monotonic() + seconds
        while process.poll() is None and time.monotonic() < end:
            yield
        output.seek(0)
        lines = [line for line in output.read().splitlines() if line.strip()]
    code = process.returncode
    return code, lines or [f"{command[0]} ended with exit code {code} and without a message."]


def program(context, which):
    """Return the path of a program. Raises RefusedError if it cannot be run."""
    name = getattr(context.preferences.addons[__name__].preferences, which)
    found = shutil.which(os.path.expanduser(bpy.path.abspath(name)))  # noqa: PTH111 - may be empty
    if found is None:
        raise RefusedError(f"{name} was not found: choose it in the preferences of this add-on.")
    return found


def active_take(context):
    """Return the active armature's active action. Raises RefusedError if there is none."""
    rig = context.view_layer.objects.active
    if rig is None or rig.type != "ARMATURE":
        raise RefusedError("The active object is not an armature: select one.")
    action = rig.animation_data.action if rig.animation_data else None
    if action is None:
        raise RefusedError(f"The armature {rig.name} has no action.")
    if not bpy.data.filepath:
        raise RefusedError("Save the .blend first: its clips and sessions are written next to it.")
    render = context.scene.render
    clip = clip_path(bpy.data.filepath, rig.name, action.name)
    first = float(action.frame_range[0])
    return Take(rig.name, action.name, clip, first, render.fps / render.fps_base)


def opening(context, report):
    """Write the BVH, start Twist Inspector, and yield while waiting."""
    take, inspector = active_take(context), program(context, "inspector")
    if take.clip.exists():  # never replaced, because a session may belong to it
        report("WARNING", f"{take.clip.name} was written before; delete it to write it again.")
    else:
        twistcore = program(context, "twistcore")
        with tempfile.TemporaryDirectory() as folder:
            copy = Path(folder, "scene.blend")
            bpy.ops.wm.save_as_mainfile(filepath=str(copy), copy=True, check_existing=False)
            blender = bpy.app.binary_path or sys.executable  # the latter for the module bpy
            _, lines = yield from run(convert_command(twistcore, copy, take, blender))
        if not take.clip.is_file():
            raise RefusedError(lines[-1])
        for line in lines:
            report("INFO", line)
    code, lines = yield from run([inspector, str(take.clip)], WATCHED)
    if code:
        raise RefusedError(lines[-1])
    report("INFO", f"{take.clip.name} was opened in Twist Inspector.")


def taking(context, report, dry_run):
    """Set keys for the accepted corrections, and yield while waiting."""
    take, twistcore = active_take(context), program(context, "twistcore")
    if not take.clip.exists():
        raise RefusedError(f"There is no {take.clip.name}: click Open in Twist Inspector first.")
    session = session_path(take.clip)
    if not session.exists():
        raise RefusedError(f"There is no {session.name}: save it in Twist Inspector (Ctrl+S).")
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder, "keys.py")
        _, lines = yield from run(export_command(twistcore, take, script, dry_run))
        if not script.is_file():
            raise RefusedError(lines[-1])
        code = compile(script.read_text("utf-8"), script.name, "exec")
    for line in lines:
        if "; run it in " not in line:  # the script is run here
            report("WARNING", line)

    def tell(line):
        report("WARNING" if line.startswith("note:") else "INFO", line)

    try:
        exec(code, {"__name__": "__main__", "print": tell})
    except RuntimeError as error:
        raise RefusedError(str(error)) from None


class Waiting:
    """An operator that Blender does not wait for when a person clicks it, but a script does."""

    def execute(self, context):
        self._lines, self._steps = [], self.steps(context)
        while (result := self._advance(context)) == {"RUNNING_MODAL"}:
            time.sleep(0.05)
        return result

    def invoke(self, context, event):
        self._lines, self._steps = [], self.steps(context)
        result = self._advance(context)
        if result == {"RUNNING_MODAL"}:
            self._timer = context.window_manager.event_timer_add(0.2, window=context.window)
            context.window_manager.modal_handler_add(self)
        return result

    def modal(self, context, event):
        if event.type == "TIMER" and (result := self._advance(context)) != {"RUNNING_MODAL"}:
            context.window_manager.event_timer_remove(self._timer)
            return result
        return {"PASS_THROUGH"}

    def cancel(self, context):  # Blender quits or opens another file
        context.window_manager.event_timer_remove(self._timer)
        self._steps.close()

    def _tell(self, kind, line):
        self.report({kind}, line)
        self._lines.append(line)

    def _advance(self, context):
        try:
            next(self._steps)
        except (RefusedError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        except StopIteration:
            lines, popup = self._lines, context.window_manager.popup_menu
            if not bpy.app.background:
                popup(
                    lambda m, _: [m.layout.label(text=line) for line in lines], title=self.bl_label
                )
            return {"FINISHED"}
        return {"RUNNING_MODAL"}


class OpenTake(Waiting, bpy.types.Operator):
    """Write the active armature's action as a BVH next to the .blend, and open it"""

    bl_idname = "twist_inspector.open_take"
    bl_label = "Open in Twist Inspector"

    def steps(self, context):
        return opening(context, self._tell)


class TakeDecisions(Waiting, bpy.types.Operator):
    """Set rotation keys in the active action for the intervals accepted in Twist Inspector"""

    bl_idname = "twist_inspector.take_decisions"
    bl_label = "Take decisions"
    dry_run: bpy.props.BoolProperty(name="Dry run: only report the keys", default=True)

    def steps(self, context):
        return taking(context, self._tell, self.dry_run)


class Sidebar(bpy.types.Panel):
    """The buttons in the 3D view's sidebar"""

    bl_idname = "VIEW3D_PT_twist_inspector"
    bl_label = "Twist Inspector"
    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "Twist"

    def draw(self, context):
        self.layout.operator(OpenTake.bl_idname)
        for dry_run, text in ((True, "Take decisions: dry run"), (False, "Take decisions")):
            self.layout.operator(TakeDecisions.bl_idname, text=text).dry_run = dry_run


class Preferences(bpy.types.AddonPreferences):
    """The paths of the programs"""

    bl_idname = __name__
    twistcore: bpy.props.StringProperty(subtype="FILE_PATH", default="twistcore")
    inspector: bpy.props.StringProperty(subtype="FILE_PATH", default="twist-inspector")

    def draw(self, context):
        self.layout.prop(self, "twistcore", text="twistcore")
        self.layout.prop(self, "inspector", text="twist-inspector")


register, unregister = bpy.utils.register_classes_factory(
    (OpenTake, TakeDecisions, Sidebar, Preferences)
)
