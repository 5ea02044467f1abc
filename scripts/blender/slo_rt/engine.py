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
        picture = os.path.join(folder, program.picture_name(job.prefix, frame, "exr"))
        self._run_passes(found, job, picture, depsgraph)

    def _tell(self, report, scene, frame):
        last_notes[:] = report.lines()
        if not self.is_animation or frame == scene.frame_start:
            for line in last_notes:
                self.report({"INFO"}, f"slo-rt: {line}")

    def _run_passes(self, found, job, picture, depsgraph):
        values = depsgraph.scene.slo_rt
        plan = passes.planned(values.samples, self._shows_early(values), values.time)
        measured = []
        for number, samples in enumerate(plan):
            is_last = number == len(plan) - 1
            if is_last and values.time > 0.0 and measured:
                samples = passes.within(values.time, samples, measured)
            begin = time.monotonic()
            # The scene says `samples` itself: without the option the program may go on where it stopped.
            option = None if samples == values.samples else samples
            if not self._run(found, job, option, samples):
                return
            self._show(picture, depsgraph)
            measured.append((samples, time.monotonic() - begin))

    def _shows_early(self, values):
        return values.show_early and not self.is_animation and not bpy.app.background

    def _run(self, found, job, option, samples):
        """One run of the program; False if it was stopped."""
        command = found.command(job.scene_path, job.first, os.path.dirname(job.scene_path), option)

        def on_progress(fraction):
            self.update_progress(fraction)
            self.update_stats("slo-rt", f"{samples} samples, {100.0 * fraction:.0f} %")

        on_progress(0.0)
        outcome = process.run(command, on_progress, self.test_break)
        if outcome.stopped or outcome.code in process.STOPPED_CODES:
            self.update_stats("slo-rt", "Stopped")
            return False
        if not outcome.succeeded:
            raise RenderFailed(f"slo-rt: {outcome.complaint()}\n(scene: {job.scene_path})")
        return True

    def _show(self, picture, depsgraph):
        """Hands the picture to Blender: all of it, or the part inside of the render border."""
        pixels = linear_pixels(picture)
        left, bottom = _border_corner(depsgraph.scene.render)
        width, height = self.resolution_x, self.resolution_y
        shown = pixels[bottom : bottom + height, left : left + width]
        result = self.begin_result(0, 0, width, height, layer=depsgraph.view_layer.name)
        combined = result.layers[0].passes["Combined"]
        combined.rect.foreach_set(np.ascontiguousarray(shown).ravel())
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
