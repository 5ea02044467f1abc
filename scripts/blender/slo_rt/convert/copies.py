# SPDX-License-Identifier: GPL-3.0-or-later
"""Instances: few of them are copies with key frames, many are placements in a file.

Many instances of one thing by one instancer hang in the instancer's space, as long as they are at
rest there. So a forest on a moving island is one file and the key frames of the island. Other
instances that are at rest in the world, such as many collection instances, are placements too.
"""

from dataclasses import dataclass, field

import numpy as np

from ..fit.rigid import axes_of, matrix_of, quaternions, split_affine
from .motion import space_key
from .places import frame_of

# So many instances of one thing are placements.
MANY = 16
# Largest motion of an instance in its instancer's space, in units of its size.
REST = 1e-4
# Rounding of positions, in units of their distance from the origin.
ROUNDING = 1e-6


@dataclass
class Space:
    """The space of an instancer, a `bpy` object."""

    instancer: object
    placement: np.ndarray = None
    is_used: bool = False
    reach: np.ndarray = field(default_factory=lambda: np.zeros(3))

    @property
    def key(self):
        """Its key in the timeline."""
        return space_key(self.instancer.name_full)

    @property
    def name(self):
        """What its element is called, more or less."""
        return f"{self.instancer.name}_instances"

    @property
    def subject(self):
        """What notes call it."""
        return f'object "{self.instancer.name}"'


@dataclass
class Crowd:
    """Many instances (`members`) of one thing that are at rest in the space of their instancer, or in the
    world, and their placements there (n, 12)."""

    space: Space | None
    members: list
    placements: np.ndarray = None

    @property
    def original(self):
        """What they show."""
        return self.members[0].original

    def columns(self):
        """Returns positions, turns and scales for a file; None for what none of them has."""
        turns = quaternions(axes_of(self.placements[:, 3:6], self.placements[:, 6:9]))
        scales = self.placements[:, 9:]
        straight = np.abs(turns[:, 1:]).max() == 0.0
        plain = (scales == 1.0).all()
        return self.placements[:, :3], None if straight else turns, None if plain else scales


class Crowds:
    """The spaces of instancers, by full name, and the crowds in them."""

    def __init__(self, things):
        self.spaces = {}
        self._groups = {}
        self._instances = [thing for thing in things if thing.is_instance]
        for thing in things:
            if thing.is_instance:
                instancer = thing.sources[1]
                group = id(thing.original), instancer.name_full
                self._groups.setdefault(group, []).append(thing)
                if thing.frame:
                    self._space(instancer)
        self._groups = {key: one for key, one in self._groups.items() if len(one) >= MANY}
        for group in self._groups.values():
            self._space(group[0].sources[1])

    def _space(self, instancer):
        return self.spaces.setdefault(instancer.name_full, Space(instancer))

    @property
    def instancers(self):
        """The objects whose spaces may be needed."""
        return [space.instancer for space in self.spaces.values()]

    def gather(self, timeline):
        """Returns the crowds, after the timeline has sampled the scene."""
        crowds = []
        for space in self.spaces.values():
            begin = timeline.matrices([space.key], np.array([[timeline.begin]]))[0, 0]
            space.placement = split_affine(begin)[0]
        for group in self._groups.values():
            space = self._space(group[0].sources[1])
            crowd = _at_rest(space, group, timeline)
            if len(crowd.members) >= MANY:
                space.is_used = True
                reach = np.abs(crowd.placements[:, :3]).max(axis=0) + crowd.original.reach
                space.reach = np.maximum(space.reach, reach)
                crowds.append(crowd)
        return crowds + self._in_the_world(crowds, timeline)

    def _in_the_world(self, crowds, timeline):
        """Returns the crowds of instances that are in no other and never move."""
        settled = {member.key for crowd in crowds for member in crowd.members}
        groups = {}
        for thing in self._instances:
            if thing.key not in settled and thing.frame is None and not timeline.moves(thing.key):
                groups.setdefault(id(thing.original), []).append(thing)
        return [
            Crowd(None, group, np.array([thing.placement for thing in group]))
            for group in groups.values()
            if len(group) >= MANY
        ]


def _at_rest(space, things, timeline):
    """Returns the crowd of those things that are at rest in a space."""
    keys = [thing.key for thing in things]
    states = timeline.states([*keys, space.key])
    local = rests = None
    reach = things[0].original.reach
    for state in states:
        frame = frame_of(state[-1])
        if local is None:
            matrices = np.array([thing.matrix for thing in things])
            local = np.linalg.inv(matrix_of(space.placement)) @ matrices
            placements, rests = split_affine(local)
            sizes = np.linalg.norm(matrices[:, :3, :3] * reach, axis=(1, 2))
            is_alike = (rests == things[0].rest).all(axis=(1, 2))
        off = np.abs(frame @ local - state[:-1])
        gaps = off[:, :3, 3] + (off[:, :3, :3] * reach).sum(axis=2)
        allowed = REST * sizes + ROUNDING * np.abs(state[:-1, :3, 3]).max(axis=1)
        is_alike &= gaps.max(axis=1) <= allowed
    members = [thing for thing, one in zip(things, is_alike) if one]
    return Crowd(space, members, placements[is_alike])
