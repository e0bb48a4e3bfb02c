"""Take pictures of the 3D view at print resolution, with the line widths scaled to match."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from PySide6.QtCore import QSize
from PySide6.QtGui import QImage
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkRenderer,
    vtkRenderWindow,
    vtkWindowToImageFilter,
)

from inspector.viewport.viewport import Viewport

_SAMPLES = 4  # samples per pixel, for smooth edges even with software rendering
_LARGEST = 8192  # maximum width and height in pixels, because drivers refuse more


def view_picture(viewport: Viewport, size: QSize) -> QImage:
    """Return a picture of a view in the given size, without the overlays of the view."""
    view = viewport.view
    assert view is not None
    viewport.grab()  # the context must exist, and everything must be drawn
    window = view.ren_win
    assert window is not None
    times = size.width() / max(1, viewport.width())
    most = min(1.0, _LARGEST / max(size.width(), size.height()))
    with _larger(window, times * most, size * most):
        window.Render()
        grabber = vtkWindowToImageFilter()
        grabber.SetInput(window)
        grabber.ReadFrontBufferOff()
        grabber.ShouldRerenderOff()
        grabber.Update()
        data = grabber.GetOutput()
    wide, high, _ = data.GetDimensions()
    rows = vtk_to_numpy(data.GetPointData().GetScalars()).reshape(high, wide, 3)
    pixels = np.ascontiguousarray(rows[::-1])
    return QImage(pixels.data, wide, high, 3 * wide, QImage.Format.Format_RGB888).copy()


@contextmanager
def _larger(window: vtkRenderWindow, times: float, size: QSize) -> Iterator[None]:
    """Enlarge the window and its line widths within the context.

    `times` is the factor for the line widths, and `size` is the new size of the window.
    """
    old, samples = window.GetSize(), window.GetMultiSamples()
    looks = [a.GetProperty() for a in _actors(window)]
    widths = {look: look.GetLineWidth() for look in looks}
    for look, width in widths.items():
        look.SetLineWidth(times * width)
    window.SetMultiSamples(_SAMPLES)
    window.SetSize(size.width(), size.height())
    try:
        yield
    finally:
        for look, width in widths.items():
            look.SetLineWidth(width)
        window.SetMultiSamples(samples)
        window.SetSize(*old)


def _actors(window: vtkRenderWindow) -> Iterator[vtkActor]:
    """Yield the VTK actors in all layers of the view."""
    renderers = window.GetRenderers()
    for k in range(renderers.GetNumberOfItems()):
        renderer = renderers.GetItemAsObject(k)
        assert isinstance(renderer, vtkRenderer)
        actors = renderer.GetActors()
        for n in range(actors.GetNumberOfItems()):
            actor = actors.GetItemAsObject(n)
            assert isinstance(actor, vtkActor)
            yield actor
