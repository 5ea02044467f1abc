# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine: writes the frame as a scene, runs slo-rt, shows its picture."""

import math
import os
import tempfile
import time

import bpy
import numpy as np

from . import exports, passes, preferences, process, program
from .convert.scene import Job, write_scene
from .convert.settings import picture_size
from .format.names import plain

# What the last rendering or export could not carry over, for the panel.
last_notes = []


class RenderFailed(Exception):
    """The picture can't be made; the message is for the artist."""


class SloRtRenderEngine(bpy.types.RenderEngine):
    """slo-rt as a render engine of Blender."""

    bl_idname = exports.ENGINE
    bl_label = "slo-rt"
    bl_use_preview = False
    bl_use_eevee_viewport = True
    bl_use_postprocess = True

    def render(self, depsgraph):
        """Called by Blender for each frame and view layer."""
        request = exports.take_request()
        if request:
            self._export(depsgraph, request)
            return
        try:
            self._render_frame(depsgraph)
        except (RenderFailed, program.ProgramMissing, OSError, ValueError) as error:
            self.error_set(str(error))
            self.report({"ERROR"}, str(error))

    # Export

    def _export(self, depsgraph, request):
        job = Job(
            depsgraph=depsgraph,
            set_frame=self._set_frame,
            scene_path=request.scene_path,
            first=request.first,
            last=request.last,
            prefix=request.prefix,
            output=request.output,
        )
        try:
            request.report = write_scene(job)
            last_notes[:] = request.report.lines()
        except (OSError, ValueError) as error:
            request.error = error

    def _set_frame(self, frame):
        whole = math.floor(frame)
        self.frame_set(whole, subframe=frame - whole)

    # Rendering

    def _render_frame(self, depsgraph):
        found = program.find(preferences.preferred_path())
        scene = depsgraph.scene
        frame = scene.frame_current
        folder = work_folder(scene.name)
        self.update_stats("slo-rt", f"Writing frame {frame}")
        job = Job(
            depsgraph=depsgraph,
            set_frame=self._set_frame,
            scene_path=os.path.join(folder, "frame.txt"),
            first=frame,
            last=frame,
            prefix="frame_",
            output="EXR_IMAGE",
            by_content=True,
        )
        self._tell(write_scene(job), scene, frame)
        self._set_frame(float(frame))
        remove_stale_meshes(job.scene_path)
        picture = os.path.join(folder, program.picture_name(job.prefix, frame, "exr"))
        self._run_passes(found, job, picture, depsgraph)

    def _tell(self, report, scene, frame):
        last_notes[:] = report.lines()
        if not self.is_animation or frame == scene.frame_start:
            for line in last_notes:
                self.report({"INFO"}, f"slo-rt: {line}")

    def _run_passes(self, found, job, picture, depsgraph):
        values = depsgraph.scene.slo_rt
        plan = passes.planned(values.samples, self._shows_early(values))
        measured = []
        while True:
            if values.time > 0.0:
                samples = passes.following(values.time, values.samples, measured)
            else:
                samples = plan[len(measured)] if len(measured) < len(plan) else None
            begin = time.monotonic()
            if samples is None or not self._run(found, job, samples, values.samples):
                return
            self._show(picture, depsgraph)
            measured.append((samples, time.monotonic() - begin))

    def _shows_early(self, values):
        return values.show_early and not self.is_animation and not bpy.app.background

    def _run(self, found, job, samples, all_samples):
        """One run of the program; False if it was stopped."""
        # The scene says how many samples there are in all, and a run with all of them needs no option.
        option = None if samples == all_samples else samples
        command = found.command(job.scene_path, job.first, os.path.dirname(job.scene_path), option)

        self._show_progress(0.0, samples)
        outcome = process.run(
            command, lambda fraction: self._show_progress(fraction, samples), self._should_stop
        )
        if outcome.stopped or outcome.code in process.STOPPED_CODES:
            self.update_stats("slo-rt", "Stopped")
            return False
        if not outcome.succeeded:
            raise RenderFailed(f"slo-rt: {outcome.complaint()}\n(scene: {job.scene_path})")
        return True

    def _show_progress(self, fraction, samples):
        self.update_progress(fraction)
        self.update_stats("slo-rt", f"{samples} samples, {100.0 * fraction:.0f} %")

    def _should_stop(self):
        return self.test_break()

    def _show(self, picture, depsgraph):
        """Hands the picture to Blender: all of it, or the part inside of the render border."""
        pixels = linear_pixels(picture)
        left, bottom = _border_corner(depsgraph.scene.render)
        height, width, _ = pixels.shape
        result = self.begin_result(0, 0, width, height, layer=depsgraph.view_layer.name)
        # Blender cuts the result down to the border.
        right, top = left + result.resolution_x, bottom + result.resolution_y
        shown = np.ascontiguousarray(pixels[bottom:top, left:right])
        result.layers[0].passes["Combined"].rect.foreach_set(shown.ravel())
        self.end_result(result)
        os.remove(picture)


def linear_pixels(path):
    """Pixels of an EXR file as they are, (height, width, 4), the bottom row first.

    `RenderLayer.load_from_file` reads files of Blender only, so the file becomes an image of Blender for
    a moment.
    """
    image = bpy.data.images.load(path)
    try:
        width, height = image.size
        pixels = np.empty(width * height * 4, np.float32)
        image.pixels.foreach_get(pixels)
    finally:
        bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)


def _border_corner(render):
    """Left and bottom of the render border in pixels of the whole picture; 0 without."""
    if not render.use_border:
        return 0, 0
    width, height = picture_size(render)
    return int(render.border_min_x * width), int(render.border_min_y * height)


def remove_stale_meshes(scene_path):
    """Removes meshes of earlier frames that the scene does not use, which would fill the disk."""
    with open(scene_path, encoding="utf-8") as file:
        text = file.read()
    folder = os.path.splitext(scene_path)[0]
    for name in os.listdir(folder):
        if name.endswith(".slo") and name not in text:
            os.remove(os.path.join(folder, name))


_session_folder = None


def work_folder(scene_name):
    """A folder for the files of a scene, which lasts as long as Blender runs."""
    global _session_folder
    if _session_folder is None or not os.path.isdir(_session_folder):
        _session_folder = tempfile.mkdtemp(prefix="slo-rt-", dir=bpy.app.tempdir or None)
    folder = os.path.join(_session_folder, plain(scene_name))
    os.makedirs(folder, exist_ok=True)
    return folder


classes = (SloRtRenderEngine,)
