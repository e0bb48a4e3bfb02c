"""Show a lesson page's place in the program, and describe the place that is currently shown."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from inspector.language import tr
from inspector.lessons.guided_program import GuidedProgram
from inspector.lessons.lesson_place import TABS, Camera, LessonPlace
from inspector.session.open_clip import Show
from inspector.session.opening import Analysed
from inspector.viewport.camera import OrbitCamera
from twistcore.analysis.decomposition import WhatIf
from twistcore.detection import DEFAULT_METHOD
from twistcore.skeleton.rotation import Array

_LOOKS = "skin", "side_by_side"
_NOTHING_KEPT = tr(
    "A lesson does not save anything. When it ends, your own clip comes back unchanged."
)


class ViewBefore:
    """The view of the figure before a lesson or exercise, to be restored afterwards."""

    def __init__(self, program: GuidedProgram) -> None:
        self._program = program
        self._show = program.document.show
        self._looks = {look: program.actions[look].isChecked() for look in _LOOKS}

    def restore(self) -> None:
        """Restore the view from before the lesson."""
        self._program.document.set_show(self._show)
        for look, checked in self._looks.items():
            self._program.actions[look].setChecked(checked)


def show_lesson_place(program: GuidedProgram, data: Analysed, place: LessonPlace) -> None:
    """Show the place of a page: its frame, chain, view, τ and symbols.

    `data` is the clip of the page.
    """
    document, taught = program.document, program.taught
    if document.data is not data:
        program.aside.show(data, _NOTHING_KEPT)
    in_front = dict(zip(TABS, (program.show_teaching, program.show_intervals), strict=True))
    in_front[place.tab]()
    document.set_show(Show(place.look))
    program.actions["skin"].setChecked(place.skin)
    program.actions["side_by_side"].setChecked(False)  # the page decides which figures are shown
    if place.chain:
        document.select_chain(place.chain)
    _set_taus(program, place)
    document.select_interval(_interval_at(program, place))
    document.go_to(place.frame)
    taught.reset()
    taught.remove_highlight()
    taught.set_what_if(place.what_if)
    taught.set_stage(place.stage)
    if place.lit:
        taught.highlight(place.lit)
    taught.set_rows(place.show)
    program.viewport.focus_chain()
    if (camera := place.camera) is not None:
        facing = _facing(program)
        if facing is not None:
            program.viewport.steer(lambda best: _from_side(best, camera, facing))


def _set_taus(program: GuidedProgram, place: LessonPlace) -> None:
    """Set the τ of the page for its chain, and the detector's automatic τ for all other chains."""
    document = program.document
    now = document.review.state.tau
    wanted = {name: document.detector.automatic_tau(name) for name in now}
    if place.tau is not None and place.chain in wanted:
        wanted[place.chain] = place.tau
    document.set_taus({name: tau for name, tau in wanted.items() if now[name] != tau})


def current_lesson_place(program: GuidedProgram) -> LessonPlace | None:
    """Return the place that the program shows now, or None if no clip is open."""
    document, taught, viewport = program.document, program.taught, program.viewport
    data = document.data
    if data is None:
        return None
    teaches = taught.active
    own, tau = document.detector, document.review.state.tau.get(document.chain)
    automatic = tau is None or tau == own.automatic_tau(document.chain)
    return LessonPlace(
        clip=data.clip.path,
        frame=document.frame,
        chain=document.chain,
        camera=_present_camera(program) if viewport.view is not None else None,
        lit=taught.lit if teaches else "",
        what_if=taught.what_if if teaches else WhatIf(),
        stage=taught.stage if teaches else None,
        tab=TABS[0] if teaches else TABS[1],
        look=document.show.value,
        skin=program.actions["skin"].isChecked(),
        tau=None if automatic else tau,
        detector="" if document.method == DEFAULT_METHOD else document.method,
    )


def _interval_at(program: GuidedProgram, place: LessonPlace) -> int | None:
    """Return the id of the interval at the page's frame, or None if there is none.

    Returns None as well if the page shows the teaching tab.
    """
    if place.tab == TABS[0]:
        return None
    for judged in program.document.intervals:
        own = judged.interval
        if own.chain == place.chain and own.start <= place.frame < own.stop:
            return judged.id
    return None


def _facing(program: GuidedProgram) -> Array | None:
    scene, document = program.viewport.scene, program.document
    if scene is None or document.data is None:
        return None
    return scene.facing(document.data.positions[document.frame])


def _from_side(best: OrbitCamera, camera: Camera, facing: Array) -> OrbitCamera:
    """Return a limb's default camera, `best`, changed to the direction and zoom of a lesson page.

    `facing` is the direction in which the figure faces.
    """
    turned = replace(best, ahead=facing, azimuth=camera.azimuth, elevation=camera.elevation)
    return turned.zoomed(camera.zoom)


def _present_camera(program: GuidedProgram) -> Camera | None:
    """Return the current camera relative to the limb's default camera.

    Returns None if the current camera is the default camera.
    """
    viewport, facing = program.viewport, _facing(program)
    now = viewport.camera
    if now is None or facing is None:
        return None
    viewport.focus_chain()
    best = viewport.camera
    viewport.steer(lambda _: now)
    assert best is not None
    if np.allclose([now.distance, *now.position], [best.distance, *best.position], rtol=1e-6):
        return None
    level = replace(now, ahead=facing).looking_from(now.direction)
    return Camera(level.azimuth, level.elevation, best.distance / now.distance)
