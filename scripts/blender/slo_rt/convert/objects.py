# SPDX-License-Identifier: GPL-3.0-or-later
"""The elements of things: meshes, copies, and the spaces of instancers."""

import re

import numpy as np

from ..format import key_frames
from ..format.scene_text import Element, block, exact

# Shapes at even times, with consecutive numbers, are one line if there are at least so many.
SEVERAL = 4
_NUMBERED = re.compile(r"(.*)_(\d{4})\.ply")
AT_REST = np.array([0, 0, 0, 0, 0, 1, 1, 0, 0, 1, 1, 1], np.float64)


class Objects:
    """Writes the elements of things. `surfaces` knows materials, `names` names objects, and `store(name,
    columns) -> filename` writes placements."""

    def __init__(self, fps, surfaces, names, store):
        self._fps = fps
        self._surfaces = surfaces
        self._names = names
        self._store = store
        self._hidden = {}  # names of the elements of originals, by their identities

    def elements(self, things, spaces, crowds, paths):
        """Returns the elements of things. `spaces` are those of instancers by full name, `paths` are key
        frames by key."""
        settled = {member.key: crowd for crowd in crowds for member in crowd.members}
        shared = self._shared(things, settled)
        for thing in things:
            if thing.frame and thing.key not in settled:
                spaces[thing.frame].is_used = True
        elements, groups = self._groups(spaces, paths)
        written = set()
        for thing in things:
            original, crowd = thing.original, settled.get(thing.key)
            if crowd is None and not (thing.is_instance and id(original) in shared):
                elements += self._meshes(thing, self._keys(thing.key, thing.placement, paths))
                continue
            if id(original) not in self._hidden:
                elements += self._original(thing)
            name = self._hidden[id(original)]
            if crowd is None:
                elements.append(self._copy(thing, name, groups, paths))
            elif id(crowd) not in written:
                written.add(id(crowd))
                elements.append(self._copies(crowd, name, groups))
        return elements

    @staticmethod
    def _shared(things, settled):
        """Returns the identities of originals that copies show."""
        counts = {}
        for thing in things:
            if thing.is_instance:
                many = 2 if thing.frame or thing.key in settled else 1
                counts[id(thing.original)] = counts.get(id(thing.original), 0) + many
        return {one for one, count in counts.items() if count > 1}

    def _groups(self, spaces, paths):
        """Returns the elements of the spaces in use, and their names by full name of the instancer."""
        elements, names = [], {}
        for full_name, space in spaces.items():
            keys = self._keys(space.key, space.placement, paths) if space.is_used else []
            if keys:
                names[full_name] = self._names.new(space.name)
                elements.append(Element("group", names[full_name], keys))
        return elements, names

    def _keys(self, key, placement, paths):
        """Returns the key frames of what has a key: its path, or else its placement (12,)."""
        if key in paths:
            return key_frames.moving(paths[key], self._fps)
        return [] if np.array_equal(placement, AT_REST) else [key_frames.still(placement)]

    def _meshes(self, thing, more):
        """Returns the meshes of a thing, with `more` in their bodies."""
        elements = []
        for part in thing.parts:
            wish = thing.name
            if len(thing.parts) > 1 and part.material:
                wish = f"{thing.name}_{part.material.name}"
            body = self._part(thing, part)
            elements.append(Element("mesh", self._names.new(wish), [*body, *more]))
        return elements

    def _original(self, thing):
        """Returns the hidden elements of what copies show."""
        if len(thing.parts) == 1:
            elements = self._meshes(thing, [])
            elements[0].body.insert(0, ("hidden", 1))
        else:
            name = self._names.new(thing.name)
            elements = [Element("group", name, [("hidden", 1)])]
            elements += self._meshes(thing, [("parent", name)])
        self._hidden[id(thing.original)] = elements[0].name
        return elements

    def _copy(self, thing, name, groups, paths):
        placement = thing.placement if thing.frame is None else thing.local_placement
        parent = [("parent", groups[thing.frame])] if thing.frame in groups else []
        keys = self._keys(thing.key, placement, paths)
        return Element("copy", self._names.new(thing.name), [("of", name), *parent, *keys])

    def _copies(self, crowd, name, groups):
        wish, parent = f"{crowd.members[0].name}_copies", []
        if crowd.space:
            wish = f"{crowd.space.instancer.name}_{crowd.members[0].name}"
            full_name = crowd.space.instancer.name_full
            parent = [("parent", groups[full_name])] if full_name in groups else []
        body = [("of", name), ("placements", self._store(wish, crowd.columns()))]
        return Element("copies", self._names.new(wish), [*body, *parent])

    def _part(self, thing, part):
        """Returns the attributes of a part, without key frames."""
        files = self._shapes(part.shapes) if part.shapes else [("filename", part.filename)]
        return [
            *files,
            ("smooth_normals", int(part.smooth)),
            ("material", self._surfaces.name_of(part.material)),
            *self._light(thing, part),
        ]

    def _shapes(self, shapes):
        """Returns the attributes of a part that changes its shape; see `Part.shapes`."""
        times = np.array([time for time, _ in shapes])
        steps = np.diff(times)
        names = [_NUMBERED.fullmatch(filename) for _, filename in shapes]
        if len(shapes) >= SEVERAL and np.ptp(steps) < 1e-9 and all(names):
            base = names[0].group(1)
            files = [f"{base}_{number:04d}.ply" for number in range(1, len(shapes) + 1)]
            if "#" not in base and files == [filename for _, filename in shapes]:
                body = [("filename", f"{base}_####.ply"), ("first", 1), ("last", len(shapes))]
                body.append(("fps", exact(self._fps / steps[0])))
                return [block("shapes", [*body, ("time", exact(times[0] / self._fps))])]
        return [
            block("addShape", [("time", exact(time / self._fps)), ("filename", filename)])
            for time, filename in shapes
        ]

    def _light(self, thing, part):
        """Returns the attributes of a part that shines."""
        if not self._surfaces.emits(part.material):
            return []
        group = [("light_group", thing.group)] if thing.group else []
        ours = getattr(part.material, "cycles", None)
        is_asked = getattr(ours, "emission_sampling", "AUTO") != "NONE"
        return group + ([] if is_asked else [("sampled", 0)])
