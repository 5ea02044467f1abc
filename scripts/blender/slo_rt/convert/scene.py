# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes Blender's evaluated scene as a scene text with its meshes and textures."""

import hashlib
import os
from dataclasses import dataclass, replace
from itertools import count

import numpy as np

from .. import compat
from ..fit.motion import sample_times
from ..fit.rigid import split_affine
from ..format import key_frames, ply, scene_text, slo_mesh
from ..format.fingerprint import fingerprint
from ..format.names import Names, plain
from ..format.scene_text import Element
from ..report import Report
from . import bending, environment, lamp, light, limits, motion, nodes, settings, world
from . import camera as cameras
from .copies import Crowds
from .objects import Objects
from .paths import Mover, Paths
from .surfaces import PhysicalSurfaces, Surfaces
from .surroundings import Surroundings
from .things import NOTHING, Collector, Thing

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
        self.files = {}  # paths in the scene, by the contents of meshes
        self.sequences = {}  # names and numbers of shapes
        self.names = {kind: Names() for kind in ("file", "object")}

    def write(self):
        job = self.job
        if self.scene.camera is None:
            raise ValueError("the scene has no camera")
        os.makedirs(self.folder, exist_ok=True)
        job.set_frame(float(job.first))
        self.changing = motion.changed_shapes(job.depsgraph) if self._moving else set()
        self.world = (self.layer.world_override or self.scene.world) if self.layer.use_sky else None
        sky = self._read_world()
        self.collector = Collector(
            self._store_mesh,
            self.surfaces.look_of,
            self.shutter.duration > 0.0,
            self.changing.__contains__,
            self.report,
        )
        found = self.collector.take_stock(job.depsgraph)
        crowds = Crowds(found.things)
        self.surroundings = Surroundings(found.things)
        lights = [] if self.is_physical else self._lights(found.lamps)
        bent = _bent(found.things + found.nothing)
        timeline = self._timeline(found, crowds, bent)
        self._wake_nothing(found, timeline)
        self._note_darkness([*sky, *(found.lamps if self.is_physical else lights)], found.things)
        materials = self.surfaces.elements(found.things)
        camera = self._camera(timeline)
        gathered = crowds.gather(timeline)
        paths = self._paths(found, crowds, gathered, timeline)
        for each in bent.values():
            self._finish(each)
        if self.is_physical and found.lamps:
            job.set_frame(float(job.first))  # lights are as at the first frame
            lights = self._lamps(found.lamps, paths)
        elements = [*sky, *lights, *materials]
        objects = Objects(self.fps, self.surfaces, self.names["object"], self._store_placements)
        elements += objects.elements(found.things, crowds.spaces, gathered, paths)
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
        text = scene_text.write(head + elements, self._comments())
        _write_text(job.scene_path, text)
        if job.preview_path:
            head = [settings.preview_settings_element(self.scene), camera]
            _write_text(job.preview_path, scene_text.write(head + elements))
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

    def _timeline(self, found, crowds, bent):
        """Samples the whole scene, and looks at the shapes of `bent` (by the key of a thing that has them)."""
        shots = cameras.shots(self.scene, self.job.first, self.job.last)
        used = {camera.name_full: camera for camera, _, _ in shots}.values()
        for camera in used:
            cameras.note_limits(camera, self.render, self.report)
        size = settings.picture_size(self.render)
        reader = cameras.CameraReader(self.render, *size, self.report)
        start, job = float(self.job.first), self.job
        timeline = motion.Timeline(
            job.depsgraph, job.set_frame, start, list(used), reader, found.keys, crowds.instancers
        )
        timeline.visit([start])
        for camera in used:
            values = timeline.camera_values(camera, [start])[0]
            self.surroundings.note_clipping(camera, values, self.report)
        if self._moving:
            times = sample_times(*self._span)
            timeline.visit(times, self._looks(timeline, times, bent) if bent else None)
        return timeline

    def _looks(self, timeline, times, bent):
        """Returns functions, by time, that look at the shapes of `bent`."""

        def look(time, is_border):
            changed = motion.changed_shapes(self.job.depsgraph)
            anew = {key for key in bent if key[0] in changed or time == times[0]}
            seen = set()
            for key, instance in timeline.instances(anew):
                thing, one = instance.object, bent[key]
                mesh = thing.to_mesh()
                if mesh is not None:
                    matrix = np.array(instance.matrix_world, np.float64)
                    one.original.bending.look(
                        time, is_border, mesh, _rest_of(one, matrix), self._store_shape
                    )
                    seen.add(key)
                thing.to_mesh_clear()
            for key in bent.keys() - seen:
                bent[key].original.bending.look(time, is_border, None, None, self._store_shape)

        watched = bending.watched(times, self.shutter.duration > 0.0)
        return {
            float(time): lambda time=float(time), border=border: look(time, border)
            for time, border in zip(*watched)
        }

    def _finish(self, thing):
        """Gives a thing that may bend its files."""
        original = thing.original
        original.bending.finish(original.parts, self._store_mesh)
        if original.bending.bends and self.shutter.duration > 0.0:
            limits.note_bending_blur(thing.sources[0], self.report)
        if original.bending.is_broken:
            self.report.note(
                thing.subject, f"its faces change; it has those of frame {self.job.first}"
            )

    def _wake_nothing(self, found, timeline):
        """Notes things that are scaled to nothing, except for those that grow."""
        for thing in found.nothing:
            growing = timeline.moves(thing.key) and any(
                np.linalg.norm(state[0, :3, :3], axis=0).min() > 0.0
                for state in timeline.states([thing.key])
            )
            if growing:
                found.things.append(thing)
            else:
                self.report.note(thing.subject, NOTHING)

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

    def _paths(self, found, crowds, gathered, timeline):
        """Returns the key frames of what moves, by their keys."""
        if not self._moving:
            return {}
        settled = {member.key for crowd in gathered for member in crowd.members}
        movers = [
            Mover(
                thing,
                thing.key,
                thing.sources,
                thing.original.reach,
                thing.original.box[1] - thing.original.box[0],
                frame=thing.frame,
            )
            for thing in found.things
            if thing.key not in settled and self._moves(thing, timeline)
        ]
        movers += [
            Mover(each, each.key, each.sources, np.zeros(3), np.zeros(3), self._size_of_lamp(each))
            for each in (found.lamps if self.is_physical else ())
            if timeline.moves(each.key)
        ]
        movers += [
            Mover(space, space.key, [space.instancer], space.reach, 2.0 * space.reach, 1e-3)
            for space in crowds.spaces.values()
            if timeline.moves(space.key)
        ]
        paths = Paths(movers, timeline)
        self._reshape(paths, timeline)
        first, last = self._span
        fitted = paths.fit(first, last, lambda mover: self._breaks(mover, first, last))
        for mover, misfit in paths.misfits:
            self.report.note(
                mover.item.subject,
                f"moves too wildly at frame {misfit.time:.2f}: off by up to "
                f"{100.0 * misfit.position:.3g} % of its size and {np.degrees(misfit.direction):.3g} degrees",
            )
        return fitted

    def _moves(self, thing, timeline):
        """Whether a thing moves in the world, or in the space in which it hangs."""
        moves = timeline.moves(thing.key)
        return moves or (thing.frame is not None and timeline.moves(motion.space_key(thing.frame)))

    def _reshape(self, paths, timeline):
        """Gives shapes to things whose shear or mirroring changes, since key frames have neither."""
        sheared = {}
        for mover in paths.reshaped:
            if mover.is_rigid:
                note = f"its scale changes; it is as at frame {self.job.first}"
                self.report.note(mover.item.subject, note)
            elif isinstance(mover.item, Thing) and not mover.item.original.bending:
                sheared[mover.key] = mover
        if not sheared:
            return
        timeline.go(self.job.first)
        times, borders = bending.watched(sample_times(*self._span), self.shutter.duration > 0.0)
        for key, instance in timeline.instances(sheared):
            thing = sheared[key].item
            rests = split_affine(paths.matrices_of(sheared[key], times))[1]
            override = self.layer.material_override
            bent, parts, shape = self.collector.bending(instance.object, rests[0], override)
            for time, border, rest in zip(times, borders, rests):
                bent.take(float(time), border, shape, rest, self._store_shape)
            bent.finish(parts, self._store_mesh)
            thing.original = replace(thing.original, parts=parts, bending=bent)

    def _size_of_lamp(self, each):
        """Returns the size, in metres, that the errors of a lamp's path are relative to."""
        own = lamp.size_of(self._now(each.light), each.matrix)
        return max(own, LEAST_LAMP * self.surroundings.diagonal, 1e-3)

    def _breaks(self, mover, first, last):
        """Returns the `Break`s of all sources of a mover. Many things share their sources."""
        remapped = self.render.frame_map_new / self.render.frame_map_old
        found = []
        for source in mover.sources:
            if source.name_full not in self.breaks:
                self.breaks[source.name_full] = motion.breaks(source, first, last, remapped)
            found += self.breaks[source.name_full]
        return found

    def _store_mesh(self, name, arrays):
        """Writes a mesh, each only once, and returns its path in the scene."""
        digest = arrays.digest()
        if digest not in self.files:
            name = digest if self.job.by_content else self.names["file"].new(name)
            path = os.path.join(self.folder, f"{name}.slo")
            if not (self.job.by_content and os.path.exists(path)):
                slo_mesh.write(path, arrays)
            self.files[digest] = f"{self.folder_name}/{name}.slo"
        return self.files[digest]

    def _store_shape(self, sequence, name, arrays):
        """Writes a shape of the part `sequence`, each only once, and returns its path in the scene."""
        digest = arrays.digest()
        if (sequence, digest) not in self.files:
            if self.job.by_content:
                name = digest
            else:
                if sequence not in self.sequences:
                    self.sequences[sequence] = self.names["file"].new(name), count(1)
                base, numbers = self.sequences[sequence]
                name = f"{base}_{next(numbers):04d}"
            path = os.path.join(self.folder, f"{name}.ply")
            if not (self.job.by_content and os.path.exists(path)):
                ply.write_mesh(path, arrays)
            self.files[sequence, digest] = f"{self.folder_name}/{name}.ply"
        return self.files[sequence, digest]

    def _store_placements(self, name, columns):
        """Writes where copies are, and returns the path in the scene."""
        if self.job.by_content:
            hashes = [b"" if each is None else fingerprint(each) for each in columns]
            name = hashlib.blake2b(b";".join(hashes), digest_size=16).hexdigest()
        else:
            name = self.names["file"].new(name)
        path = os.path.join(self.folder, f"{name}.ply")
        if not (self.job.by_content and os.path.exists(path)):
            ply.write_placements(path, *columns)
        return f"{self.folder_name}/{name}.ply"

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


def _bent(things):
    """Returns one thing for each original that may bend, by its key."""
    firsts = {id(thing.original): thing for thing in reversed(things) if thing.original.bending}
    return {thing.key: thing for thing in firsts.values()}


def _rest_of(thing, matrix):
    """Returns what must be done to the vertices of a thing with a matrix (4, 4), or None for nothing."""
    rest = thing.rest if thing.frame else split_affine(matrix)[1]
    return None if np.array_equal(rest, np.eye(3)) else rest


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
