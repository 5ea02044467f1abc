# SPDX-License-Identifier: GPL-3.0-or-later
"""File > Export, and what the panels' buttons do."""

import os

import bpy
import numpy as np
from bpy.props import BoolProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from . import engine, exports
from .convert import mesh as meshes
from .convert.checks import finite
from .convert.things import SOLID
from .fit.rigid import split_matrix
from .format import slo_mesh
from .format.names import Names, plain


def target_path(filepath, ending):
    """Returns the file to write for the artist's input: absolute, with its ending, never a `.blend`.

    # Errors `ValueError` where that names no file.
    """
    if filepath.startswith("//") and not bpy.data.filepath:
        raise ValueError("// is the folder of the .blend file: save that first")
    path = os.path.abspath(os.path.expanduser(bpy.path.abspath(filepath)))
    stem, typed = os.path.splitext(path)
    if typed.lower() == ".blend":
        path = stem
    path = bpy.path.ensure_ext(path, ending)
    if os.path.isdir(path) or os.path.basename(path) == ending or filepath.endswith(("/", os.sep)):
        raise ValueError(f"{filepath!r} names no file")
    return path


class SLO_RT_OT_export_scene(bpy.types.Operator, ExportHelper):
    """Write the scene as text that slo-rt renders, with its meshes and textures in a folder beside
    it"""

    bl_idname = "slo_rt.export_scene"
    bl_label = "Export slo-rt Scene"
    bl_options = {"PRESET"}

    filename_ext = ".txt"
    filter_glob: StringProperty(default="*.txt", options={"HIDDEN"})
    animation: BoolProperty(
        name="Animation",
        description="All frames of the frame range; otherwise the current frame",
        default=True,
    )

    def execute(self, context):
        scene = context.scene
        first, last = scene.frame_start, scene.frame_end
        if not self.animation:
            first = last = scene.frame_current
        try:
            path = target_path(self.filepath, self.filename_ext)
            prefix = plain(os.path.splitext(os.path.basename(path))[0]) + "_"
            report = exports.export_scene(scene, context.view_layer, path, first, last, prefix)
        except Exception as error:
            self.report({"ERROR"}, engine.complaint(error))
            return {"CANCELLED"}
        for line in report.lines():
            self.report({"WARNING"}, line)
        self.report({"INFO"}, f"Wrote {path}")
        return {"FINISHED"}


class SLO_RT_OT_export_mesh(bpy.types.Operator, ExportHelper):
    """Write the selected objects as .slo meshes, one file each, modifiers applied and scale baked
    in"""

    bl_idname = "slo_rt.export_mesh"
    bl_label = "Export slo-rt Mesh"
    bl_options = {"PRESET"}

    filename_ext = ".slo"
    filter_glob: StringProperty(default="*.slo", options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        return any(thing.type in SOLID for thing in context.selected_objects)

    def execute(self, context):
        depsgraph = context.evaluated_depsgraph_get()
        things = [thing for thing in context.selected_objects if thing.type in SOLID]
        try:
            stem = os.path.splitext(target_path(self.filepath, self.filename_ext))[0]
            names, written = Names(), 0
            for thing in things:
                path = stem + (f"_{names.new(thing.name)}" if len(things) > 1 else "") + ".slo"
                written += self._write(path, thing.evaluated_get(depsgraph))
        except Exception as error:
            self.report({"ERROR"}, engine.complaint(error))
            return {"CANCELLED"}
        return {"FINISHED"} if written else {"CANCELLED"}

    def _write(self, path, thing):
        """Writes an evaluated object; returns whether it has triangles."""
        triangles = arrays_of_object(thing)
        if triangles is None:
            self.report({"WARNING"}, f"{thing.name} has no faces")
            return False
        try:
            slo_mesh.write(path, triangles)
        except ValueError as error:
            raise ValueError(f'object "{thing.name}": {error}') from error
        self.report({"INFO"}, f"Wrote {path}: {len(triangles.faces)} triangles")
        return True


def arrays_of_object(thing):
    """Returns the triangles of an evaluated object in its own space, scale baked in; None without faces.

    # Errors `ValueError` if its scale is not finite.
    """
    matrix = finite(np.array(thing.matrix_world, np.float64), f'object "{thing.name}"')
    _, shape = split_matrix(matrix)
    is_scaled = not np.allclose(shape, np.eye(3), rtol=0.0, atol=1e-6)
    mesh = thing.to_mesh()
    try:
        if mesh is None or not meshes.has_faces(mesh):
            return None
        return meshes.Triangles(mesh, shape if is_scaled else None).arrays("", False)
    finally:
        thing.to_mesh_clear()


class SLO_RT_OT_copy_notes(bpy.types.Operator):
    """Copy the list of what was not carried over"""

    bl_idname = "slo_rt.copy_notes"
    bl_label = "Copy"

    def execute(self, context):
        context.window_manager.clipboard = "\n".join(engine.last_notes)
        return {"FINISHED"}


def draw_export_menu(menu, _context):
    """The entries of File > Export."""
    menu.layout.operator(SLO_RT_OT_export_scene.bl_idname, text="slo-rt Scene (.txt)")
    menu.layout.operator(SLO_RT_OT_export_mesh.bl_idname, text="slo-rt Mesh (.slo)")


classes = (SLO_RT_OT_export_scene, SLO_RT_OT_export_mesh, SLO_RT_OT_copy_notes)
