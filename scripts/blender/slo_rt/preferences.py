# SPDX-License-Identifier: GPL-3.0-or-later
"""Preferences of the extension: where the program is."""

import bpy

from . import program


class SloRtPreferences(bpy.types.AddonPreferences):
    """Where slo-rt is, and whether it runs."""

    bl_idname = __package__

    program_path: bpy.props.StringProperty(
        name="Program",
        description="Path of slo-rt; empty: the one on the PATH",
        subtype="FILE_PATH",
    )

    def draw(self, _context):
        self.layout.prop(self, "program_path")
        found = draw_program(self.layout)
        if found:
            self.layout.label(text=f"{found.version}: {found.path}", icon="CHECKMARK")


def draw_program(layout):
    """Draws the error of the program, if any; returns the program, or None."""
    try:
        return program.find(preferred_path())
    except program.ProgramMissing as error:
        column = layout.column()
        column.alert = True
        for i, sentence in enumerate(str(error).split(". ")):
            column.label(text=sentence, icon="BLANK1" if i else "ERROR")
        return None


def preferred_path():
    """Returns the absolute path that the user chose; empty if none."""
    addon = bpy.context.preferences.addons.get(__package__)
    path = addon.preferences.program_path if addon and addon.preferences else ""
    return bpy.path.abspath(path) if path.startswith("//") else path


classes = (SloRtPreferences,)
