# SPDX-License-Identifier: GPL-3.0-or-later
"""Notes on properties of objects, view layers and render settings that slo-rt lacks."""

import bpy

from .flags import note_flags
from .physics import note_unbaked
from .settings import is_carried

# Kinds of rays from which Blender can hide an object.
_RAYS = ("camera", "diffuse", "glossy", "transmission", "shadow")
_PASSES = ("use_pass_", "pass_debug", "pass_render", "denoising_store_passes")
# Ways to show particles other than as objects.
_PARTICLES = {"HALO": "halos", "LINE": "lines", "PATH": "paths"}
# View settings that do not change colours.
_PLAIN_VIEW = {
    "view_transform": "Standard",
    "look": "None",
    "exposure": 0.0,
    "gamma": 1.0,
    "use_curve_mapping": False,
    "use_white_balance": False,
}


def note_object(thing, view_layer, report):
    """Notes the visibility settings of `thing` (an evaluated object) that slo-rt lacks."""
    is_light = thing.type == "LIGHT"
    subject, original = f'{"light" if is_light else "object"} "{thing.name}"', thing.original
    if not is_light:
        if thing.is_holdout or original.holdout_get(view_layer=view_layer):
            report.note(subject, "a holdout in Blender; it is seen in slo-rt")
        if thing.is_shadow_catcher:
            report.note(subject, "a shadow catcher in Blender; it is seen itself in slo-rt")
        if original.indirect_only_get(view_layer=view_layer):
            report.note(subject, "seen only indirectly in Blender; it is seen in slo-rt")
    hidden = [ray for ray in _RAYS if not getattr(thing, f"visible_{ray}")]
    if is_light and "camera" in hidden:
        hidden.remove("camera")  # as all lights of Blender are; what shines and is seen is noted
    if hidden:
        report.note(subject, f"hidden from {', '.join(hidden)} rays in Blender, not in slo-rt")
    note_flags(getattr(thing, "cycles", None), "CyclesObjectSettings", subject, report)
    for modifier in thing.modifiers:
        if modifier.type == "SUBSURF" and modifier.show_render:
            note_flags(modifier, "SubsurfModifier", subject, report)
    linking = thing.light_linking
    if linking and (linking.receiver_collection or linking.blocker_collection):
        report.note(subject, "light linking is not carried: lights shine on everything")


def note_particles(thing, report):
    """Notes hair and particles of `thing` that are not shown as objects, since they have no objects."""
    for system in thing.particle_systems:
        how = system.settings
        subject = f'particle system "{system.name}" of object "{thing.name}"'
        if how.render_type in _PARTICLES:
            kind = "hair" if how.type == "HAIR" else f"particles as {_PARTICLES[how.render_type]}"
            report.note(subject, f"{kind} not carried")


def note_physics(depsgraph, report):
    """Notes physics that is not baked, of all objects, visible or not."""
    for thing in depsgraph.objects:
        note_unbaked(thing.original, depsgraph.scene, report)


def is_empty(thing):
    """Whether an object that is not a mesh has no data of its own kind, such as hair that geometry
    nodes turn into a mesh."""
    data = thing.data
    if thing.type == "VOLUME":
        data.grids.load()
        return not len(data.grids)
    parts = {"CURVES": "points", "POINTCLOUD": "points", "GREASEPENCIL": "layers"}.get(thing.type)
    return bool(parts) and not len(getattr(data, parts))


def note_blur(thing, report):
    """Notes an object that Cycles does not blur; only for an open shutter."""
    if not getattr(getattr(thing, "cycles", None), "use_motion_blur", True):
        report.note(f'object "{thing.name}"', "not blurred in Blender; it is in slo-rt")


def note_bending_blur(thing, report):
    """Notes an object (the original) whose changes of shape Cycles does not blur; only for an open
    shutter."""
    ours = getattr(thing, "cycles", None)
    if getattr(ours, "use_motion_blur", True) and not getattr(ours, "use_deform_motion", True):
        report.note(
            f'object "{thing.name}"',
            "its changes of shape are not blurred in Blender; they are in slo-rt",
        )


def note_view_layer(layer, report):
    """Notes the settings of a view layer that slo-rt lacks."""
    subject = f'view layer "{layer.name}"'
    note_flags(layer, "ViewLayer", subject, report)
    passes = [
        each.name
        for owner in (layer, getattr(layer, "cycles", None))
        for each in (owner.bl_rna.properties if owner else ())
        if each.identifier.startswith(_PASSES) and getattr(owner, each.identifier)
        if each.identifier not in {"use_pass_combined", "use_pass_cryptomatte_accurate"}
    ]
    if passes or layer.aovs:
        names = ", ".join(passes + [aov.name for aov in layer.aovs])
        report.note(subject, f"there is only the picture, not its passes: {names}")


def note_scene(scene, report):
    """Notes the render settings that slo-rt lacks."""
    render = scene.render
    note_flags(getattr(scene, "cycles", None), "CyclesRenderSettings", "scene", report)
    if render.film_transparent:
        report.note("scene", "the background is not transparent in slo-rt")
    if render.use_multiview:
        report.note("scene", "one view is rendered, not two for stereo")
    if render.use_motion_blur and getattr(render, "motion_blur_shutter_curve", None):
        points = render.motion_blur_shutter_curve.curves[0].points
        if any(abs(point.location[1] - 1.0) > 1e-3 for point in points):
            report.note("scene", "the shutter opens and closes at once, whatever its curve")
    space = getattr(getattr(bpy.data, "colorspace", None), "working_space", "Linear Rec.709")
    if space != "Linear Rec.709":
        report.note("scene", f"its colours, {space}, are taken for linear Rec.709")


def note_export(scene, layer, report, has_film):
    """Notes what Blender does to a rendered picture or sequence, but nobody does to the pictures of an
    exported scene. `has_film`: the film carries some view settings."""
    view = scene.view_settings
    odd = [
        f"{name.removeprefix('use_').replace('_', ' ')} {value}"
        for name, plain in _PLAIN_VIEW.items()
        for value in [getattr(view, name, plain)]
        if value != plain and not (has_film and is_carried(name, value))
    ]
    device = scene.display_settings.display_device
    odd += [f"display {device}"] if device != "sRGB" else []
    if odd:
        report.note(
            "scene",
            f"colours are changed by {', '.join(odd)} in Blender, not here"
            if has_film
            else f"colours are plain sRGB here, and changed by {', '.join(odd)} in Blender; "
            "View Transform Standard, without more, shows what slo-rt writes",
        )
    if scene.frame_step != 1:
        report.note("scene", f"all frames are here; Blender renders one of {scene.frame_step}")
    others = [other.name for other in scene.view_layers if other.use and other != layer]
    if others:
        report.note(
            "scene", f'view layer "{layer.name}" is here, and not {", ".join(map(repr, others))}'
        )
