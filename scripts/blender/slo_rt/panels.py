# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels in the properties editor."""

import bpy

from . import engine, preferences
from .convert.material import finish
from .convert.physical import surface_of
from .exports import ENGINE
from .report import Report

# Panels of Blender that are made for its own engines but work as they are.
BORROWED = {
    "DATA_PT_EEVEE_light",
    "DATA_PT_camera_dof",
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_MATERIAL_PT_surface",
    "EEVEE_WORLD_PT_surface",
}
# Panels for all engines that show what slo-rt does not have, or what our own panels show.
NOT_OURS = {"DATA_PT_light", "DATA_PT_preview", "MATERIAL_PT_preview", "RENDER_PT_simplify"}


class _Panel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"

    @classmethod
    def poll(cls, context):
        return context.engine == ENGINE


class _RenderPanel(_Panel):
    bl_context = "render"


class SLO_RT_PT_sampling(_RenderPanel, bpy.types.Panel):
    """How many samples, from where, for how long"""

    bl_label = "Sampling"

    def draw(self, context):
        layout, values = self.layout, context.scene.slo_rt
        layout.use_property_split = True
        preferences.draw_program(layout)
        layout.prop(values, "integrator")
        layout.prop(values, "samples")
        column = layout.column(align=True)
        column.prop(values, "noise")
        row = column.row()
        row.active = values.noise > 0.0
        row.prop(values, "min_samples")
        layout.prop(values, "time")
        layout.prop(values, "generator")
        layout.prop(values, "seed")
        layout.prop(values, "show_early")
        if values.is_physical:
            layout.prop(values, "show_preview")


class SLO_RT_PT_light_paths(_RenderPanel, bpy.types.Panel):
    """How far rays go"""

    bl_label = "Light Paths"

    def draw(self, context):
        layout, values = self.layout, context.scene.slo_rt
        layout.use_property_split = True
        if values.is_physical:
            self._draw_physical(layout, context.scene)
            return
        layout.prop(values, "recursion")
        column = layout.column(align=True)
        column.prop(values, "shadow_samples", text="Samples: Shadow")
        column.prop(values, "reflection_samples")
        column.prop(values, "refraction_samples")
        layout.prop(values, "light_sampling")
        layout.prop(values, "shadow")
        layout.prop(values, "world_light")

    @staticmethod
    def _draw_physical(layout, scene):
        values = scene.slo_rt
        if hasattr(scene, "cycles"):
            layout.prop(values, "use_cycles_bounces")
        if values.use_cycles_bounces and hasattr(scene, "cycles"):
            layout.prop(scene.cycles, "max_bounces", text="Bounces")
        else:
            layout.prop(values, "bounces")
        if values.integrator == "PATH":
            layout.prop(values, "photons")
        else:
            layout.prop(values, "photon_map_size")
            layout.prop(values, "cache_error")
        layout.prop(values, "light_sampling")


class SLO_RT_PT_motion_blur(_RenderPanel, bpy.types.Panel):
    """The shutter"""

    bl_label = "Motion Blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_motion_blur", text="")

    def draw(self, context):
        layout, render = self.layout, context.scene.render
        layout.use_property_split = True
        layout.active = render.use_motion_blur
        layout.prop(render, "motion_blur_position", text="Position")
        layout.prop(render, "motion_blur_shutter", text="Shutter")


class SLO_RT_PT_performance(_RenderPanel, bpy.types.Panel):
    """What changes the speed and not the picture"""

    bl_label = "Performance"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, values = self.layout, context.scene.slo_rt
        layout.use_property_split = True
        layout.prop(values, "accelerator")
        splits = layout.row()
        splits.active = values.accelerator == "BVH"
        splits.prop(values, "spatial_splits")
        layout.prop(values, "threads")


class SLO_RT_PT_notes(_RenderPanel, bpy.types.Panel):
    """What the last rendering or export could not carry over"""

    bl_label = "Not Carried Over"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and bool(engine.last_notes)

    def draw(self, _context):
        column = self.layout.column(align=True)
        for note in engine.last_notes:
            subject, _, message = note.partition(": ")
            column.label(text=subject, icon="INFO")
            column.label(text=message, icon="BLANK1")
        self.layout.operator("slo_rt.copy_notes")


class SLO_RT_PT_material(_Panel, bpy.types.Panel):
    """How the material looks in slo-rt"""

    bl_label = "slo-rt"
    bl_context = "material"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.material is not None

    def draw(self, context):
        layout, material = self.layout, context.material
        values = material.slo_rt
        layout.use_property_split = True
        layout.prop(values, "use_own")
        if not values.use_own:
            if context.scene.slo_rt.is_physical:
                self._draw_notes(layout, material)
            else:
                self._draw_converted(layout, material)
            return
        layout.prop(values, "ambient")
        layout.prop(values, "diffuse")
        layout.prop(values, "specular")
        layout.prop(values, "shininess")
        for strength, spread in (
            ("reflectance", "diffuse_reflection"),
            ("refraction", "diffuse_refraction"),
        ):
            column = layout.column(align=True)
            column.prop(values, strength)
            column.prop(values, spread)
        layout.prop(values, "refraction_index")

    @staticmethod
    def _draw_converted(layout, material):
        report = Report()
        phong = finish(material, (0.0, 0.0, 0.0), report).phong
        column = layout.column(align=True)
        column.label(
            text=f"Reflects {phong.reflectance:.2f}, spread {phong.diffuse_reflection:.2f}"
        )
        if phong.refraction > 0.0:
            column.label(
                text=f"Refracts {phong.refraction:.2f}, spread {phong.diffuse_refraction:.2f}"
            )
        for note in report.lines():
            column.label(text=note.partition(": ")[2], icon="INFO")

    @staticmethod
    def _draw_notes(layout, material):
        report = Report()
        surface_of(material, report)
        column = layout.column(align=True)
        if not len(report):
            column.label(text="Carried over completely", icon="CHECKMARK")
        for note in report.lines():
            column.label(text=note.partition(": ")[2], icon="INFO")


class SLO_RT_PT_light(_Panel, bpy.types.Panel):
    """How the light is carried over"""

    bl_label = "slo-rt"
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return super().poll(context) and context.light is not None

    def draw(self, context):
        layout, light = self.layout, context.light
        layout.use_property_split = True
        if context.scene.slo_rt.is_physical:
            layout.prop(light.slo_rt, "brightness")
            return
        if light.type not in {"POINT", "AREA", "SUN"}:
            layout.label(text=f"slo-rt has no {light.type.lower()} lights", icon="ERROR")
            return
        layout.prop(light.slo_rt, "brightness")
        if light.type != "SUN":
            layout.prop(light.slo_rt, "distance")


def _shared_panels():
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        is_general = engines and "BLENDER_RENDER" in engines and panel.__name__ not in NOT_OURS
        if is_general or (engines and panel.__name__ in BORROWED):
            yield panel


def join_shared_panels():
    """Makes Blender's own panels appear with our engine."""
    for panel in _shared_panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def leave_shared_panels():
    """Removes our engine from Blender's own panels."""
    for panel in _shared_panels():
        panel.COMPAT_ENGINES.discard(ENGINE)


classes = (
    SLO_RT_PT_sampling,
    SLO_RT_PT_light_paths,
    SLO_RT_PT_motion_blur,
    SLO_RT_PT_performance,
    SLO_RT_PT_notes,
    SLO_RT_PT_material,
    SLO_RT_PT_light,
)
