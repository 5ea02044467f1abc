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
        try:
            found = program.find(preferred_path())
        except program.ProgramMissing as error:
            column = self.layout.column()
            column.alert = True
            for sentence in str(error).split(". "):
                column.label(
                    text=sentence,
                    icon="ERROR" if sentence == str(error).split(". ")[0] else "BLANK1",
                )
            return
        self.layout.label(text=f"{found.version}: {found.path}", icon="CHECKMARK")


def preferred_path():
    """The path that the user chose, absolute; empty if none."""
    addon = bpy.context.preferences.addons.get(__package__)
    path = addon.preferences.program_path if addon and addon.preferences else ""
    return bpy.path.abspath(path) if path else ""


classes = (SloRtPreferences,)
