# SPDX-License-Identifier: GPL-3.0-or-later
"""Physics that is not baked. Blender computes it only while frames are played one after the other, so
the objects that it moves are at rest in a rendering or an export."""

import os

import bpy

NODES = "simulation of geometry nodes"


def note_unbaked(thing, scene, report):
    """Notes physics of an object (the original) that is not baked."""
    for kind in sorted(set(_unbaked(thing, scene))):
        message = f"its {kind} is not baked, so what it moves may rest; bake it (Physics > Cache)"
        if kind == NODES:
            message = f"unless its {kind} is baked, what it moves may rest"
        report.note(f'object "{thing.name}"', message)


def _unbaked(thing, scene):
    world = scene.rigidbody_world
    if thing.rigid_body and thing.rigid_body.type == "ACTIVE" and world and world.enabled:
        if not world.point_cache.is_baked:
            yield "rigid body"
    for modifier in thing.modifiers:
        if modifier.show_render:
            yield from _unbaked_modifier(modifier)


def _unbaked_modifier(modifier):
    kind = modifier.type
    if kind in {"CLOTH", "SOFT_BODY"} and not modifier.point_cache.is_baked:
        yield "cloth" if kind == "CLOTH" else "soft body"
    elif kind == "PARTICLE_SYSTEM":
        yield from _unbaked_particles(modifier.particle_system)
    elif kind == "DYNAMIC_PAINT" and modifier.canvas_settings:
        surfaces = modifier.canvas_settings.canvas_surfaces
        if any(s.is_active and s.is_cache_user and not s.point_cache.is_baked for s in surfaces):
            yield "dynamic paint"
    elif kind == "FLUID" and modifier.fluid_type == "DOMAIN":
        domain = modifier.domain_settings
        if domain.cache_type == "REPLAY" or not domain.has_cache_baked_data:
            yield "fluid"
    elif kind == "NODES":
        for bake in modifier.bakes:
            if bake.node and "Simulation" in bake.node.bl_idname and not _has_files(modifier, bake):
                yield NODES


def _unbaked_particles(system):
    how = system.settings
    if how.type == "EMITTER" and how.physics_type != "NO" and not system.point_cache.is_baked:
        yield "particle system"
    if how.type == "HAIR" and system.use_hair_dynamics:
        if not system.cloth.point_cache.is_baked:
            yield "hair"


def _has_files(modifier, bake):
    """Whether a bake of geometry nodes has files. Blender does not reveal a bake inside the `.blend`
    file."""
    folder = bake.directory
    if not bake.use_custom_path:
        folder = os.path.join(modifier.bake_directory, str(bake.bake_id))
    folder = bpy.path.abspath(folder)
    return bool(folder) and os.path.isdir(os.path.join(folder, "meta"))
