# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes Blender's evaluated scene as a scene text with its meshes and textures."""

import os
from dataclasses import dataclass

import numpy as np

from .. import compat
from ..fit.motion import fit_all, sample_times
from ..fit.rigid import split_matrix
from ..format import key_frames, scene_text, slo_mesh
from ..format.names import Names, plain
from ..format.scene_text import Element
from ..report import Report
from . import camera as cameras
from . import light, limits, motion, nodes, settings, world
from .surfaces import Surfaces
from .surroundings import Surroundings
from .things import Collector, outlines

# A shape counts as changing if its entries change by more than this fraction of the thing's size.
SHAPE_TOLERANCE = 1e-4
# Most times at which deforming things are checked.
OUTLINE_TIMES = 32


@dataclass
class Job:
    """What to write, and how.

    `depsgraph` is the dependency graph, and `set_frame(frame)` moves it to a time in frames.
    `scene_path` is the file to write; meshes and textures go to a folder beside it with its name.
    `first` to `last` are the frames, whole numbers. `output` is the Film's format. `by_content` names
    meshes by a hash of their contents, so that none is written twice. `notes` holds pairs of subject
    and message with which the report begins.
    """

    depsgraph: object
    set_frame: object
    scene_path: str
    first: int
    last: int
    prefix: str
    output: str = "PNG_IMAGE"
    by_content: bool = False
    notes: tuple = ()

    @property
    def single(self):
        """Whether the job has only one frame."""
        return self.first == self.last


def write_scene(job):
    """Writes the scene of `job`. Returns the `Report` of everything that could not be exported.

    # Errors `OSError` if a file cannot be written; `ValueError` if the scene has no camera or contains
    numbers that are not finite.
    """
    return _Writer(job).write()


class _Writer:
    def __init__(self, job):
        self.job = job
        self.scene = job.depsgraph.scene
        self.layer = job.depsgraph.view_layer
        self.render = self.scene.render
        self.values = self.scene.slo_rt
        self.report = Report()
        for note in job.notes:
            self.report.note(*note)
        self.fps = settings.frames_per_second(self.render)
        self.shutter = settings.Shutter.of(self.render, self.layer)
        beside, filename = os.path.split(job.scene_path)
        self.folder_name = plain(os.path.splitext(filename)[0])
        self.folder = os.path.join(beside, self.folder_name)
        self.breaks = {}
        self.names = {kind: Names() for kind in ("file", "object")}

    def write(self):
        job = self.job
        if self.scene.camera is None:
            raise ValueError("the scene has no camera")
        os.makedirs(self.folder, exist_ok=True)
        job.set_frame(float(job.first))
        self.world = (self.layer.world_override or self.scene.world) if self.layer.use_sky else None
        self.background = world.background(self._now(self.world), self.report)
        is_blurred = self.shutter.duration > 0.0
        ambient_light = [c * self.values.world_light for c in self.background]
        self.surfaces = Surfaces(self._now, ambient_light, self.folder, job.by_content, self.report)
        collector = Collector(self._store_mesh, self.surfaces.look_of, is_blurred, self.report)
        found = collector.take_stock(job.depsgraph)
        self.surroundings = Surroundings(found.things)
        lights = self._lights(found.lamps)
        self._note_darkness(lights)
        elements = [*lights, *self.surfaces.elements(found.things)]
        timeline = self._timeline()
        camera = self._camera(timeline)
        paths = self._paths(found.things, timeline)
        objects = [e for thing in found.things for e in self._thing(thing, paths)]
        self._note_changes(found, timeline)
        limits.note_physics(job.depsgraph, self.report)
        limits.note_view_layer(self.layer, self.report)
        limits.note_scene(self.scene, self.report)
        if job.output != "EXR_IMAGE":
            limits.note_export(self.scene, self.layer, self.report)
        head = [settings.settings_element(self.values, self.background), camera]
        text = scene_text.write(head + elements + objects, self._comments())
        _write_text(job.scene_path, text)
        return self.report

    def _now(self, item):
        """Returns an item of Blender's data with the values of the evaluated frame; None for None."""
        return item.evaluated_get(self.job.depsgraph) if item else None

    def _note_darkness(self, lights):
        """Notes that the scene has no light, which explains a black picture."""
        if lights:
            return
        ambient = self.values.world_light * max(self.background)
        seen = "surfaces are as bright as the world is" if ambient > 0.0 else "surfaces are black"
        self.report.note("scene", f"there is no light for slo-rt: {seen}", hint="No light")

    def _comments(self):
        lines = [
            f"Scene {self.scene.name!r}, written by Blender. Metres, z up; frame N here is frame N there."
        ]
        notes = self.report.lines()
        return lines + (["", "Not carried, or carried differently:"] + notes if notes else [])

    # Time

    def _timeline(self):
        shots = cameras.shots(self.scene, self.job.first, self.job.last)
        used = {camera.name_full: camera for camera, _, _ in shots}.values()
        for camera in used:
            cameras.note_limits(camera, self.render, self.report)
        size = settings.picture_size(self.render)
        reader = cameras.CameraReader(self.render, *size, self.report)
        timeline = motion.Timeline(self.job.depsgraph, self.job.set_frame, list(used), reader)
        start = float(self.job.first)
        timeline.visit([start])
        for camera in used:
            values = timeline.camera_values(camera, [start])[0]
            self.surroundings.note_clipping(camera, values, self.report)
        if self._moving:
            timeline.visit(sample_times(*self._span))
        return timeline

    @property
    def _moving(self):
        """Whether the job shows more than one moment."""
        return not self.job.single or self.shutter.duration > 0.0

    @property
    def _span(self):
        """Returns the first and the last scene time, in frames, at which a shutter is open."""
        tail = self.shutter.duration
        return self.job.first + self.shutter.offset, self.job.last + self.shutter.offset + tail

    # Camera

    def _camera(self, timeline):
        job, segments, names = self.job, [], Names()
        for camera, first, stop in cameras.shots(self.scene, job.first, job.last):
            segments += [
                cameras.segment_element(names.new(camera.name), segment, self.fps, self.shutter)
                for segment in self._segments(timeline, camera, first, stop)
            ]
        if len(segments) > 1 and self.shutter.duration > 1.0:
            self.report.note(
                "camera",
                "the shutter is open for more than a frame, and stops at the end of a segment",
            )
        film = settings.film_element(settings.picture_size(self.render), job.prefix, job.output)
        return Element("Camera", "camera", [("fps", scene_text.exact(self.fps)), film, *segments])

    def _segments(self, timeline, camera, first, stop):
        if not self._moving:
            timeline = _Frozen(timeline, float(self.job.first))
        whole_frames = [float(frame) for frame in range(first, stop)]
        positions = timeline.camera_values(camera, whole_frames)[:, :3]
        segments, misfit = cameras.segments_of_shot(
            timeline, camera, first, stop, self.shutter, self._distance_of(positions)
        )
        if misfit:
            frame, length, angle = misfit
            self.report.note(
                f'camera "{camera.name}"',
                f"moves too wildly while frame {frame} is exposed: "
                f"off by up to {length:.2g} m and {np.degrees(angle):.2g} degrees",
            )
        return segments

    def _distance_of(self, positions):
        """Returns the shortest distance from a camera at `positions` to the middle of a thing, but at
        least a thousandth of the scene. The camera's errors are relative to it."""
        shortest = min(
            np.linalg.norm(self.surroundings.centers - position, axis=1).min()
            for position in np.unique(positions, axis=0)
        )
        return max(float(shortest), 1e-3 * self.surroundings.diagonal, 1e-9)

    # Things

    def _thing(self, thing, paths):
        keys = self._key_frames(thing, paths)
        elements = []
        for part in thing.parts:
            wish = thing.name
            if len(thing.parts) > 1 and part.material:
                wish = f"{thing.name}_{part.material.name}"
            body = [
                ("filename", part.filename),
                ("smooth_normals", int(part.smooth)),
                ("material", self.surfaces.name_of(part.material)),
                *keys,
            ]
            elements.append(Element("mesh", self.names["object"].new(wish), body))
        return elements

    def _key_frames(self, thing, paths):
        if thing.key in paths:
            return key_frames.moving(paths[thing.key], self.fps)
        rest = np.concatenate([np.zeros(3), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)])
        return [] if np.array_equal(thing.placement, rest) else [key_frames.still(thing.placement)]

    def _paths(self, things, timeline):
        """Returns the key frames of the things that move, by their keys."""
        moving = [thing for thing in things if self._moving and timeline.moves(thing.key)]
        if not moving:
            return {}
        keys = [thing.key for thing in moving]
        shapes = np.array([thing.shape for thing in moving])
        shape_misses = np.zeros(len(moving))

        def sample(who, times):
            matrices = timeline.matrices([keys[number] for number in who], times)
            placements, shape = split_matrix(matrices)
            miss = np.abs(shape - shapes[who][:, None]).max(axis=(1, 2, 3))
            np.maximum.at(shape_misses, who, miss)
            return placements

        first, last = self._span
        breaks = [self._breaks(thing, first, last) for thing in moving]
        sizes = [thing.diagonal for thing in moving]
        fitted = fit_all(sample, first, last, sizes, breaks, timeline.visit)
        largest = SHAPE_TOLERANCE * np.abs(shapes).max(axis=(1, 2))
        for thing, (_, misfit), scales in zip(moving, fitted, shape_misses > largest):
            self._note_motion(thing, misfit, scales)
        return {key: path for key, (path, _) in zip(keys, fitted)}

    def _breaks(self, thing, first, last):
        """Returns the `Break`s of all sources of a thing. Many things share their sources."""
        remapped = self.render.frame_map_new / self.render.frame_map_old
        found = []
        for source in thing.sources:
            if source.name_full not in self.breaks:
                self.breaks[source.name_full] = motion.breaks(source, first, last, remapped)
            found += self.breaks[source.name_full]
        return found

    def _note_motion(self, thing, misfit, scales):
        subject = f'object "{thing.name}"'
        if scales:
            self.report.note(subject, f"its scale changes; it is as at frame {self.job.first}")
        if misfit:
            self.report.note(
                subject,
                f"moves too wildly at frame {misfit.time:.2f}: off by up to "
                f"{100.0 * misfit.position:.3g} % of its size and {np.degrees(misfit.direction):.3g} degrees",
            )

    def _store_mesh(self, name, arrays):
        name = arrays.digest() if self.job.by_content else self.names["file"].new(name)
        path = os.path.join(self.folder, f"{name}.slo")
        if not (self.job.by_content and os.path.exists(path)):
            slo_mesh.write(path, arrays)
        return f"{self.folder_name}/{name}.slo"

    def _lights(self, lamps):
        names, elements = Names(), []
        for lamp in lamps:
            elements += light.elements_of_light(
                names.new(lamp.name),
                self._now(lamp.light),
                lamp.matrix,
                self.surroundings,
                self.report,
            )
        return elements

    # Changes that slo-rt cannot represent

    def _note_changes(self, found, timeline):
        if not self._moving:
            return
        for lamp in found.lamps:
            if timeline.moves(lamp.key):
                self.report.note(f'light "{lamp.name}"', "lights don't move in slo-rt")
        if not self.job.single:
            self._note_animated_data(found)
        for key in timeline.not_always_there():
            self.report.note(
                f'object "{key[0]}"', f"appears or vanishes; it is as at frame {self.job.first}"
            )
        deforming = {thing.key: thing for thing in found.things if thing.outline is not None}
        for time in self._outline_times():
            if not deforming:
                break
            self.job.set_frame(time)
            for key, outline in outlines(self.job.depsgraph, deforming).items():
                if outline != deforming[key].outline:
                    subject = f'object "{deforming.pop(key).name}"'
                    self.report.note(
                        subject, f"changes its shape; it is as at frame {self.job.first}"
                    )

    def _outline_times(self):
        """Returns the times (frames) at which deforming things are checked: the last one, and whole
        frames: either all, or scattered irregularly, so that no oscillation is missed."""
        first, last = self._span
        frames = np.arange(self.job.first + 1, self.job.last)
        if len(frames) > OUTLINE_TIMES:
            golden = (np.arange(OUTLINE_TIMES) * 0.6180339887498949) % 1.0
            frames = frames[np.unique((golden * len(frames)).astype(int))]
        return [last, (first + last) / 2.0, *frames.astype(float)]

    def _note_animated_data(self, found):
        owners = {lamp.light for lamp in found.lamps} | {self.world, self.scene}
        owners |= {part.material for thing in found.things for part in thing.parts}
        for owner in owners - {None}:
            if any(compat.is_animated(each) for each in nodes.with_node_trees(owner)):
                kind = owner.bl_rna.name.lower().split()[-1]  # a point light is a light
                self.report.note(
                    f'{kind} "{owner.name}"',
                    f"its changes over time are not carried; it is as at frame {self.job.first}",
                )


class _Frozen:
    """A timeline that stays at one time."""

    def __init__(self, timeline, time):
        self._timeline = timeline
        self._time = time

    def camera_values(self, camera, times):
        return self._timeline.camera_values(camera, [self._time] * len(times))


def _write_text(path, text):
    partial = f"{path}.part"
    with open(partial, "w", encoding="utf-8", newline="\n") as file:
        file.write(text)
    os.replace(partial, path)
