# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine: writes the frame as a scene, runs slo-rt, shows its picture."""

import hashlib
import math
import os
import shutil
import tempfile
import time
import traceback

import bpy
import numpy as np

from . import exports, passes, preferences, process, program
from .convert.scene import Job, write_scene
from .convert.settings import PREVIEW_SAMPLES, picture_size
from .format.names import plain

# Report of the last rendering or export, for the panel.
last_notes = []


class RenderFailed(Exception):
    """The picture cannot be rendered; the message is for the artist."""


def complaint(error):
    """Returns the artist's message about an exception. The console shows where an error in the
    extension occurred."""
    if isinstance(error, (RenderFailed, program.ProgramMissing, OSError, ValueError)):
        return str(error)
    traceback.print_exception(error)
    if type(error) is RuntimeError:  # Blender's own words
        return str(error)
    return (
        f"slo-rt: a mistake in the extension, {type(error).__name__}: {error}. "
        "Please report it with what Blender's console shows"
    )


class SloRtRenderEngine(bpy.types.RenderEngine):
    """slo-rt as a render engine of Blender."""

    bl_idname = exports.ENGINE
    bl_label = "slo-rt"
    bl_use_preview = False
    bl_use_eevee_viewport = True
    bl_use_postprocess = True
    hint = ""  # warnings in the line above the picture

    def render(self, depsgraph):
        """Called by Blender for each frame and view layer."""
        request = exports.request()
        if request:
            if request.view_layer == depsgraph.view_layer.name:
                self._export(depsgraph, request)
            return
        # Blender takes an exception of an engine for a black picture and continues with the next
        # frame. Only `error_set` stops it, so every exception must be caught here.
        try:
            last_notes.clear()
            self._render_frame(depsgraph)
        except BaseException as error:  # Ctrl-C too
            message = complaint(error)
            self.error_set(message)
            self.report({"ERROR"}, message)

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
            notes=request.notes,
        )
        try:
            last_notes.clear()
            request.report = write_scene(job)
            last_notes[:] = request.report.lines()
        except Exception as error:
            request.error = error

    def _set_frame(self, frame):
        whole = math.floor(frame)
        self.frame_set(whole, subframe=frame - whole)

    # Rendering

    def _render_frame(self, depsgraph):
        found = program.find(preferences.preferred_path())
        scene = depsgraph.scene
        if scene.slo_rt.is_physical and not found.can("--integrator"):
            raise RenderFailed(
                f"{found.path} ({found.version}) does not know the integrators Path and Photon Map. "
                f"{program.WHAT_TO_DO} Or choose the integrator Distributed in the render settings."
            )
        is_path = scene.slo_rt.integrator == "PATH"
        if is_path and scene.slo_rt.photons > 0.0 and not found.can("--photons"):
            raise RenderFailed(
                f"{found.path} ({found.version}) does not know photons. {program.WHAT_TO_DO} "
                "Or set Photons to 0 in the render settings."
            )
        frame = scene.frame_current
        folder = work_folder(scene.name, depsgraph.view_layer.name)
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
            preview_path=os.path.join(folder, "preview.txt") if self._shows_preview(scene) else "",
        )
        self._tell(write_scene(job), frame == scene.frame_start)
        self._set_frame(float(frame))
        remove_stale_files(job.scene_path)
        self._run_passes(Run(found, job, scene.render), depsgraph)

    def _tell(self, report, is_first):
        last_notes[:] = report.lines()
        self.hint = report.hint
        if not self.is_animation or is_first:
            for line in last_notes:
                self.report({"INFO"}, f"slo-rt: {line}")

    def _run_passes(self, run, depsgraph):
        values = depsgraph.scene.slo_rt
        # A stopped rendering continues at once.
        goes_on = run.begin()
        if run.job.preview_path and not goes_on:
            preview = Preview(run.found, run.job, depsgraph.scene.render)
            if not self._run(preview, PREVIEW_SAMPLES, PREVIEW_SAMPLES):
                return
            self._show(preview, depsgraph)
        early = not goes_on and self._shows_early(values)
        plan = passes.planned(values.samples, early, run.goes_on)
        run.goes_on &= len(plan) > 1 or values.time > 0.0
        measured = []
        while True:
            if values.time > 0.0:
                samples = passes.following(values.time, values.samples, measured, run.goes_on)
            else:
                samples = plan[len(measured)] if len(measured) < len(plan) else None
            begin = time.monotonic()
            if samples is None:
                run.end()
                break
            if not self._run(run, samples, values.samples):
                break
            self._show(run, depsgraph)
            measured.append((samples, time.monotonic() - begin))

    def _shows_early(self, values):
        return values.show_early and self._is_watched()

    def _shows_preview(self, scene):
        values = scene.slo_rt
        return values.show_preview and values.is_physical and self._is_watched()

    def _is_watched(self):
        return not self.is_animation and not bpy.app.background

    def _run(self, run, samples, all_samples):
        """Runs the program once; returns False if it was stopped."""
        self._show_progress(0.0, samples)
        outcome = process.run(
            # The scene holds the total number of samples, so a run with all of them needs no option.
            run.command(None if samples == all_samples else samples),
            lambda fraction: self._show_progress(fraction, samples),
            self._should_stop,
        )
        if outcome.stopped or outcome.code in process.STOPPED_CODES:
            self.update_stats("slo-rt", "Stopped")
            return False
        if not outcome.succeeded:
            raise RenderFailed(
                f"slo-rt: {outcome.complaint()}\n"
                f"(frame {run.job.first} of scene {run.job.scene_path})"
            )
        return True

    def _show_progress(self, fraction, samples):
        self.update_progress(fraction)
        self.update_stats("slo-rt", self._info(fraction, samples))

    def _info(self, fraction, samples):
        """Returns the text of the line above the picture."""
        count = "1 sample" if samples == 1 else f"{samples} samples"
        parts = [self.hint, count, f"{100.0 * fraction:.0f} %"]
        return ", ".join(part for part in parts if part)

    def _should_stop(self):
        return self.test_break()

    def _show(self, run, depsgraph):
        """Passes the picture to Blender."""
        pixels = run.pixels()
        width, height = picture_size(depsgraph.scene.render)
        result = self.begin_result(0, 0, width, height, layer=depsgraph.view_layer.name)
        # Blender cuts the result down to the border.
        right, top = run.left + result.resolution_x, run.bottom + result.resolution_y
        shown = np.ascontiguousarray(pixels[run.bottom : top, run.left : right])
        if shown.shape[:2] != (result.resolution_y, result.resolution_x):
            self.end_result(result, cancel=True)
            found = f"{pixels.shape[1]} x {pixels.shape[0]}"
            raise RenderFailed(
                f"{run.found.path} wrote a picture of {found} pixels, which is another size than "
                f"Blender's. {program.WHAT_TO_DO}"
            )
        # With stereo, there is one for each view.
        for combined in result.layers[0].passes:
            if combined.name == "Combined":
                combined.rect.foreach_set(shown.ravel())
        self.end_result(result)
        os.remove(run.picture)


# Incomplete renderings, by work folder: `Run.identity`.
_begun = {}


class Run:
    """How the program is called for a frame, and where its picture lies.

    With a render border, a program that supports regions renders only that region. `left` and
    `bottom` are the position, in pixels, of Blender's region in the picture.
    """

    def __init__(self, found, job, render):
        self.found = found
        self.job = job
        self.goes_on = found.can("--keep-state")
        self.left = self.bottom = 0
        self.region = None
        if render.use_border:
            self._use_border(render)
        self.folder = os.path.dirname(job.scene_path)
        name = program.picture_name(job.prefix, job.first, "exr", self.region)
        self.picture = os.path.join(self.folder, name)
        # Meshes and textures are named by their contents, so the text identifies the scene.
        with open(job.scene_path, "rb") as file:
            self.identity = name, hashlib.blake2b(file.read()).digest()

    def _use_border(self, render):
        width, height = picture_size(render)
        left, right = (_pixel(x, width) for x in (render.border_min_x, render.border_max_x))
        bottom, top = (_pixel(y, height) for y in (render.border_min_y, render.border_max_y))
        if self.found.can("--region"):
            self.region = f"{right - left}x{top - bottom}+{left}+{height - top}"
        else:
            self.left, self.bottom = left, bottom

    def command(self, samples):
        """Returns the command line. If `samples` is None, the scene sets their number."""
        return self.found.command(
            self.job.scene_path, self.job.first, self.folder, samples, self.region, self.goes_on
        )

    def pixels(self):
        """Returns the pixels of the picture, as `linear_pixels`.

        # Errors `RenderFailed` if there is no readable picture.
        """
        if not os.path.exists(self.picture):
            raise RenderFailed(
                f"{self.found.path} ({self.found.version}) ended without an error and without a "
                f"picture, {self.picture}. {program.WHAT_TO_DO}"
            )
        try:
            pixels = linear_pixels(self.picture)
        except RuntimeError as error:
            raise RenderFailed(f"the picture {self.picture} can't be read: {error}") from error
        if not pixels.size:
            raise RenderFailed(f"the picture {self.picture} can't be read")
        return pixels

    def begin(self):
        """Removes files that other renderings left in the folder. Returns whether the same rendering was
        stopped before it was complete, so that it can be continued."""
        goes_on = _begun.get(self.folder) == self.identity
        if not goes_on:
            self._remove_states()
        if os.path.exists(self.picture):
            os.remove(self.picture)
        _begun[self.folder] = self.identity
        return goes_on and bool(self._states())

    def end(self):
        """Removes the files kept from pass to pass, once the picture is complete."""
        self._remove_states()
        _begun.pop(self.folder, None)

    def _states(self):
        return [name for name in os.listdir(self.folder) if name.endswith(".state")]

    def _remove_states(self):
        for name in self._states():
            os.remove(os.path.join(self.folder, name))


class Preview(Run):
    """How the program is called for the preview of a frame."""

    def __init__(self, found, job, render):
        super().__init__(found, job, render)
        self.folder = os.path.join(self.folder, "preview")
        os.makedirs(self.folder, exist_ok=True)
        self.picture = os.path.join(self.folder, os.path.basename(self.picture))

    def command(self, samples):
        """Returns the command line; `samples` are those of the scene."""
        path, frame = self.job.preview_path, self.job.first
        return self.found.command(path, frame, self.folder, samples, self.region)


def _pixel(fraction, size):
    """Returns a border in pixels, computed in single precision and truncated as in Blender."""
    return int(np.float32(fraction) * np.float32(size))


def linear_pixels(path):
    """Returns the unchanged pixels of an EXR file, (height, width, 4), the bottom row first.

    `RenderLayer.load_from_file` reads only files by Blender, so the file temporarily becomes a
    Blender image.
    """
    image = bpy.data.images.load(path)
    try:
        width, height = image.size
        pixels = np.empty(width * height * 4, np.float32)
        image.pixels.foreach_get(pixels)
    finally:
        bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)


def remove_stale_files(scene_path):
    """Removes meshes and textures of earlier frames that the scene does not use, since they would fill
    the disk."""
    with open(scene_path, encoding="utf-8") as file:
        text = file.read()
    folder = os.path.splitext(scene_path)[0]
    for name in os.listdir(folder):
        if name.endswith((".slo", ".ply", ".png", ".exr", ".hdr")) and name not in text:
            os.remove(os.path.join(folder, name))


_session_folder = None


def work_folder(scene, view_layer):
    """Returns the folder, by name, for the files of a view layer of a scene. It exists as long as
    Blender runs."""
    global _session_folder
    if _session_folder is None or not os.path.isdir(_session_folder):
        _session_folder = tempfile.mkdtemp(prefix="slo-rt-", dir=bpy.app.tempdir or None)
    names = hashlib.blake2b(
        f"{scene}\n{view_layer}".encode(errors="replace"), digest_size=4
    ).hexdigest()
    folder = os.path.join(_session_folder, f"{plain(scene)}_{names}")
    os.makedirs(folder, exist_ok=True)
    return folder


def remove_work_folders():
    """Removes all files of this session."""
    global _session_folder
    if _session_folder is not None:
        shutil.rmtree(_session_folder, ignore_errors=True)
        _session_folder = None
        _begun.clear()


classes = (SloRtRenderEngine,)
