# SPDX-License-Identifier: GPL-3.0-or-later
"""Every property that an artist can set is read, listed, or known to be idle."""

import unittest

import bpy

from slo_rt.convert.flags import TABLES

from . import blend

ID = {each.identifier for each in bpy.types.ID.bl_rna.properties}


class TableTest(unittest.TestCase):
    def owners(self, scene):
        """Data of each kind of the tables."""
        thing, layer = blend.cube(), scene.view_layers[0]
        material = bpy.data.materials.new("Paint")
        thing.data.materials.append(material)
        lights = [blend.lamp(kind, kind).data for kind in ("POINT", "SUN", "SPOT", "AREA")]
        camera = scene.camera.data
        return [
            ("RenderSettings", scene.render), ("ViewLayer", layer), ("Camera", camera),
            ("CameraDOFSettings", camera.dof), *(("Light", light) for light in lights),
            ("CyclesLightSettings", lights[0].cycles), ("World", scene.world),
            ("CyclesWorldSettings", scene.world.cycles), ("Material", material),
            ("CyclesMaterialSettings", material.cycles), ("Object", thing),
            ("CyclesObjectSettings", thing.cycles), ("LayerCollection", layer.layer_collection),
        ]  # fmt: skip

    def test_no_property_is_forgotten(self):
        for kind, owner in self.owners(blend.fresh_scene()):
            table = TABLES[kind]
            known = table.read | table.idle | set(table.listed) | {"animation_data", "rna_type"}
            if owner.bl_rna.base and "name" in ID:
                known |= ID
            found = {
                each.identifier
                for each in owner.bl_rna.properties
                if not each.is_readonly or each.type in {"POINTER", "COLLECTION"}
            }
            if kind == "ViewLayer":
                found = {name for name in found if not name.startswith("use_pass_")}
            self.assertEqual(found - known, set(), kind)

    def test_lists_do_not_overlap(self):
        for kind, table in TABLES.items():
            self.assertFalse(table.read & table.idle, kind)
            self.assertFalse((table.read | table.idle) & set(table.listed), kind)

    def test_what_is_listed_is_in_the_list(self):
        """In a fresh scene nothing is listed; with another value of a property, it is listed."""
        scene = blend.fresh_scene()
        owners = [*self.owners(scene), ("CyclesRenderSettings", scene.cycles)]
        for light in [thing for thing in bpy.data.objects if thing.type == "LIGHT"]:
            if light.data.type != "POINT":
                bpy.data.objects.remove(light)
        before = self.comments()
        checked = 0
        for kind, owner in owners:
            if getattr(owner, "type", "POINT") in {"SUN", "SPOT", "AREA"}:
                continue
            for name, (neutral, _) in TABLES[kind].listed.items():
                if not hasattr(owner, name):
                    continue
                self.assertEqual(getattr(owner, name), neutral, (kind, name))
                setattr(owner, name, self.other(owner, name, neutral))
                self.assertGreater(len(self.comments()), len(before), (kind, name))
                setattr(owner, name, neutral)
                self.assertEqual(self.comments(), before, (kind, name))
                checked += 1
        self.assertGreater(checked, 12)

    def other(self, owner, name, neutral):
        if isinstance(neutral, bool):
            return not neutral
        if isinstance(neutral, (int, float)):
            return type(neutral)(neutral / 2 or 3)
        items = owner.bl_rna.properties[name].enum_items
        return next(item.identifier for item in items if item.identifier != neutral)

    def comments(self):
        return [line for line in blend.export_text(animation=False).splitlines() if line[:1] == "#"]
