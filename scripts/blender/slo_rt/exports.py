# SPDX-License-Identifier: GPL-3.0-or-later
"""Export of a whole scene.

Blender evaluates a scene for rendering (render visibility, render levels of modifiers) only inside a
render engine. So an export is a rendering by the engine slo-rt that writes files and makes no
picture.
"""

import contextlib
from dataclasses import dataclass

import bpy

from . import compat

ENGINE = "SLO_RT"


@dataclass
class Request:
    """What the engine is to write. `report` or `error` is set when it is done."""

    view_layer: str
    scene_path: str
    first: int
    last: int
    prefix: str
    output: str
    notes: list
    report: object = None
    error: Exception | None = None


_pending = None


def request():
    """Returns the export that the engine does instead of a rendering, or None."""
    return _pending


def export_scene(scene, view_layer, scene_path, first, last, prefix, output="PNG_IMAGE"):
    """Writes frames `first` to `last` of a view layer of `scene` to a scene text. Returns the
    `Report`.

    # Errors `OSError`, `ValueError` as `convert.scene.write_scene`; Blender's `RuntimeError` if it
    does not render, for example without a camera.
    """
    global _pending
    notes = [("scene", message) for message in _left_to_blender(scene, view_layer)]
    wanted = Request(view_layer.name, scene_path, first, last, prefix, output, notes)
    _pending = wanted
    try:
        with _as_our_scene(scene), _switched_on(view_layer):
            bpy.ops.render.render(scene=scene.name)
    finally:
        _pending = None
    if wanted.error:
        raise wanted.error
    if wanted.report is None:
        raise RuntimeError("Blender did not start the export")
    return wanted.report


def _left_to_blender(scene, view_layer):
    """Notes what Blender does before and after a rendering by F12, but nobody does for an exported scene."""
    render = scene.render
    if render.use_freestyle and view_layer.use_freestyle:
        # Blender draws them into its own picture, and crashes if there is none.
        yield "Freestyle's lines are not carried"
    if render.use_border:
        yield "the render border is not carried: the whole picture is rendered (slo-rt has --region)"
    if render.use_multiview:
        yield "one view is rendered, not two for stereo"
    if render.use_compositing and compat.compositing_nodes(scene):
        yield "the compositor's nodes are not carried"
    if render.use_sequencer and compat.strips(scene):
        yield "the video sequencer's strips are not carried"
    if render.use_stamp:
        yield "metadata is not drawn into the picture"


@contextlib.contextmanager
def _switched_on(view_layer):
    """Turns on the rendering of the view layer, and restores it at the end."""
    before = view_layer.use
    view_layer.use = True
    try:
        yield
    finally:
        view_layer.use = before


@contextlib.contextmanager
def _as_our_scene(scene):
    """Sets our engine without post-processing for the scene, and restores both at the end."""
    render = scene.render
    wanted = {
        "engine": ENGINE,
        "use_sequencer": False,
        "use_compositing": False,
        "use_border": False,
        "use_multiview": False,
        "use_single_layer": False,
        "use_freestyle": False,
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
