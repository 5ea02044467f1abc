# SPDX-License-Identifier: GPL-3.0-or-later
"""Export of a whole scene.

Only inside of a render engine does Blender evaluate a scene for rendering: render visibility,
render levels of modifiers. So an export is a rendering by the engine slo-rt that writes files and
makes no picture.
"""

import contextlib
from dataclasses import dataclass

import bpy

ENGINE = "SLO_RT"


@dataclass
class Request:
    """What the engine is to write; `report` or `error` is set when it is done."""

    scene_path: str
    first: int
    last: int
    prefix: str
    output: str
    report: object = None
    error: Exception | None = None


_pending = None


def take_request():
    """The export that the engine is to do instead of a rendering, or None."""
    return _pending


def export_scene(scene, scene_path, first, last, prefix, output="PNG_IMAGE"):
    """Writes frames `first` to `last` of `scene` to a scene text. Returns the `Report`.

    # Errors `OSError`, `ValueError` as `convert.scene.write_scene`; `RuntimeError` of Blender where
    it does not render, as without a camera.
    """
    global _pending
    request = Request(scene_path, first, last, prefix, output)
    _pending = request
    try:
        with _as_our_scene(scene):
            bpy.ops.render.render(scene=scene.name)
    finally:
        _pending = None
    if request.error:
        raise request.error
    if request.report is None:
        raise RuntimeError("Blender did not start the export")
    return request.report


@contextlib.contextmanager
def _as_our_scene(scene):
    """The scene with our engine and nothing behind it, put back at the end."""
    render = scene.render
    wanted = {
        "engine": ENGINE,
        "use_sequencer": False,
        "use_compositing": False,
        "use_border": False,
        "use_multiview": False,
    }
    before = {name: getattr(render, name) for name in wanted}
    frame = scene.frame_current, scene.frame_subframe
    for name, value in wanted.items():
        setattr(render, name, value)
    try:
        yield
    finally:
        for name, value in before.items():
            setattr(render, name, value)
        scene.frame_set(frame[0], subframe=frame[1])
