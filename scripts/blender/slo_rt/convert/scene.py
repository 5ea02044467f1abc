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
from . import environment, lamp, light, limits, motion, nodes, settings, world
from .surfaces import PhysicalSurfaces, Surfaces
from .surroundings import Surroundings
from .things import Collector, Lamp, outlines

# A shape counts as changing if its entries change by more than this fraction of the thing's size.
SHAPE_TOLERANCE = 1e-4
# Most times at which deforming things are checked.
OUTLINE_TIMES = 32
# Moving lamps count as at least this fraction of the scene.
LEAST_LAMP = 0.01


@dataclass
class Job:
    """What to write, and how.

    `depsgraph` is the dependency graph, and `set_frame(frame)` moves it to a time in frames.
    `scene_path` is the file to write; meshes and textures go to a folder beside it with its name.
    `first` to `last` are the frames, whole numbers. `output` is the Film's format. `by_content` names
    meshes by a hash of their contents, so that none is written twice. `notes` holds pairs of subject
    and message with which the report begins. `preview_path` is where the scene goes with the settings
    of a preview, in the same folder; nowhere if it is empty.
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
    preview_path: str = ""

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
        self.is_physical = self.values.is_physical
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
        sky = self._read_world()
        is_blurred = self.shutter.duration > 0.0
        collector = Collector(self._store_mesh, self.surfaces.look_of, is_blurred, self.report)
        found = collector.take_stock(job.depsgraph)
        self.surroundings = Surroundings(found.things)
        lights = [] if self.is_physical else self._lights(found.lamps)
        self._note_darkness([*sky, *(found.lamps if self.is_physical else lights)], found.things)
        materials = self.surfaces.elements(found.things)
        timeline = self._timeline()
        camera = self._camera(timeline)
        movers = [*found.things, *(found.lamps if self.is_physical else ())]
        paths = self._paths(movers, timeline)
        if self.is_physical:
            lights = self._lamps(found.lamps, paths)
        elements = [*sky, *lights, *materials]
        objects = [e for thing in found.things for e in self._thing(thing, paths)]
        self._note_changes(found, timeline)
        limits.note_physics(job.depsgraph, self.report)
        limits.note_view_layer(self.layer, self.report)
        limits.note_scene(self.scene, self.report)
        if job.output != "EXR_IMAGE":
            limits.note_export(self.scene, self.layer, self.report, self.is_physical)
        if self.is_physical:
            head = [settings.physical_settings_element(self.scene), camera]
        else:
            head = [settings.settings_element(self.values, self.background), camera]
        text = scene_text.write(head + elements + objects, self._comments())
        _write_text(job.scene_path, text)
        if job.preview_path:
            head = [settings.preview_settings_element(self.scene), camera]
            _write_text(job.preview_path, scene_text.write(head + elements + objects))
        return self.report

    def _now(self, item):
        """Returns an item of Blender's data with the values of the evaluated frame; None for None."""
        return item.evaluated_get(self.job.depsgraph) if item else None

    def _read_world(self):
        """Reads the world, and prepares the materials, whose ambient light may depend on it. Returns
        the elements of the sky."""
        job, world_now = self.job, self._now(self.world)
        if self.is_physical:
            self.background = (0.0, 0.0, 0.0)
            self.surfaces = PhysicalSurfaces(self._now, self.folder, job.by_content, self.report)
            texture_of = self.surfaces.texture_of
            return environment.environment_elements(world_now, texture_of, self.report)
        self.background = world.background(world_now, self.report)
        ambient_light = [c * self.values.world_light for c in self.background]
        self.surfaces = Surfaces(self._now, ambient_light, self.folder, job.by_content, self.report)
        return []

    def _note_darkness(self, lights, things):
        """Notes that the scene has no light, which explains a black picture."""
        if lights or any(self.surfaces.emits(part.material) for t in things for part in t.parts):
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
        size = settings.picture_size(self.render)
        view = self.scene.view_settings if self.is_physical else None
        film = settings.film_element(size, job.prefix, job.output, view)
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
                *self._light_of_part(thing, part),
                *keys,
            ]
            elements.append(Element("mesh", self.names["object"].new(wish), body))
        return elements

    def _light_of_part(self, thing, part):
        """Returns the attributes of a part that shines."""
        if not self.surfaces.emits(part.material):
            return []
        group = [("light_group", thing.group)] if thing.group else []
        ours = getattr(part.material, "cycles", None)
        is_asked = getattr(ours, "emission_sampling", "AUTO") != "NONE"
        return group + ([] if is_asked else [("sampled", 0)])

    def _key_frames(self, thing, paths):
        if thing.key in paths:
            return key_frames.moving(paths[thing.key], self.fps)
        rest = np.concatenate([np.zeros(3), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)])
        return [] if np.array_equal(thing.placement, rest) else [key_frames.still(thing.placement)]

    def _paths(self, things, timeline):
        """Returns the key frames of the things and lamps that move, by their keys."""
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
        sizes = [self._size(thing) for thing in moving]
        fitted = fit_all(sample, first, last, sizes, breaks, timeline.visit)
        largest = SHAPE_TOLERANCE * np.abs(shapes).max(axis=(1, 2))
        for thing, (_, misfit), scales in zip(moving, fitted, shape_misses > largest):
            self._note_motion(thing, misfit, scales)
        return {key: path for key, (path, _) in zip(keys, fitted)}

    def _size(self, thing):
        """Returns the size, in metres, that the errors of a thing's path are relative to."""
        if not isinstance(thing, Lamp):
            return thing.diagonal
        own = lamp.size_of(self._now(thing.light), thing.matrix)
        return max(own, LEAST_LAMP * self.surroundings.diagonal, 1e-3)

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
        subject = thing.subject
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
        for each in lamps:
            elements += light.elements_of_light(
                names.new(each.name),
                self._now(each.light),
                each.matrix,
                self.surroundings,
                self.report,
            )
        return elements

    def _lamps(self, lamps, paths):
        names, elements = Names(), []
        for each in lamps:
            keys = key_frames.moving(paths[each.key], self.fps) if each.key in paths else []
            matrix = each.local if keys else each.matrix
            name, data = names.new(each.name), self._now(each.light)
            found = lamp.lamp_element(name, each, data, matrix, keys, self.report)
            elements += [found] if found else []
        return elements

    # Changes that slo-rt cannot represent

    def _note_changes(self, found, timeline):
        if not self._moving:
            return
        for each in found.lamps:
            if timeline.moves(each.key) and not self.is_physical:
                self.report.note(each.subject, "lights don't move in slo-rt")
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
        owners = {each.light for each in found.lamps} | {self.world, self.scene}
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
