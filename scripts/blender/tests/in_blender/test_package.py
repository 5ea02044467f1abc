# SPDX-License-Identifier: GPL-3.0-or-later
"""The package: Blender's own validator accepts it, and it installs as a zip file."""

import os
import subprocess
import sys
import types
import unittest

import bpy

import slo_rt
from slo_rt import engine, panels, preferences

from . import blend

EXTENSION = os.path.join(blend.ROOT, "scripts", "blender", "slo_rt")


def extension_tool():
    """Blender's program for extensions, which is in the wheel."""
    scripts = bpy.utils.system_resource("SCRIPTS")
    return os.path.join(scripts, "addons_core", "bl_pkg", "cli", "blender_ext.py")


def run_tool(*arguments):
    """Runs Blender's program for extensions; returns what it says."""
    done = subprocess.run(
        [sys.executable, extension_tool(), *arguments], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


class PackageTest(unittest.TestCase):
    def test_it_builds_and_is_valid(self):
        package = os.path.join(blend.FOLDER, "slo_rt.zip")
        run_tool("validate", EXTENSION)
        run_tool("build", "--source-dir", EXTENSION, "--output-filepath", package)
        run_tool("validate", package)
        listing = subprocess.run(
            [sys.executable, "-m", "zipfile", "-l", package],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for name in ("blender_manifest.toml", "LICENSE", "engine.py", "fit/motion.py"):
            self.assertIn(name, listing)
        self.assertNotIn("__pycache__", listing)

    def test_it_installs_and_renders(self):
        """Runs in a Blender process of its own, with a settings folder of its own."""
        package = os.path.join(blend.FOLDER, "installed.zip")
        run_tool("build", "--source-dir", EXTENSION, "--output-filepath", package)
        picture = os.path.join(blend.FOLDER, "installed.png")
        script = f"""
import bpy, os
bpy.ops.extensions.package_install_files(
    filepath={package!r}, repo="user_default", enable_on_install=True)
addon = bpy.context.preferences.addons["bl_ext.user_default.slo_rt"]
addon.preferences.program_path = {blend.PROGRAM!r}
scene = bpy.context.scene
scene.render.engine = "SLO_RT"
scene.render.resolution_x, scene.render.resolution_y = 40, 30
scene.slo_rt.samples = 1
scene.render.filepath = {picture!r}
bpy.ops.render.render(write_still=True)
bpy.ops.preferences.addon_disable(module="bl_ext.user_default.slo_rt")
assert not hasattr(bpy.types, "SloRtRenderEngine")
os._exit(0)
"""
        environment = {**os.environ, "BLENDER_USER_RESOURCES": os.path.join(blend.FOLDER, "user")}
        environment.pop("SLO_RT", None)
        done = subprocess.run(
            [sys.executable, "-c", script],
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertGreater(os.path.getsize(picture), 100)


class Layout:
    """Stands in for a Blender layout, which exists only in a window. Notes what is drawn, and rejects
    properties that do not exist."""

    def __init__(self, drawn):
        self.drawn = drawn

    def prop(self, owner, name, **_options):
        assert name in owner.bl_rna.properties, (owner, name)
        self.drawn.append(name)

    def label(self, text="", **_options):
        self.drawn.append(text)

    def operator(self, name, **_options):
        category, operator = name.split(".")
        assert hasattr(getattr(bpy.ops, category), operator)
        self.drawn.append(name)

    def column(self, **_options):
        return Layout(self.drawn)

    row = column


class PanelTest(unittest.TestCase):
    def setUp(self):
        self.scene = blend.fresh_scene()
        blend.program()
        self.material = bpy.data.materials.new("Paint")
        self.light = bpy.data.lights.new("Lamp", "AREA")
        self.context = types.SimpleNamespace(
            engine="SLO_RT", scene=self.scene, material=self.material, light=self.light
        )

    def draw(self, panel):
        drawn = []
        owner = types.SimpleNamespace(
            layout=Layout(drawn),
            **{
                name: value
                for name, value in vars(panel).items()
                if isinstance(value, staticmethod)
            },
        )
        panel.draw(owner, self.context)
        return drawn

    def test_every_panel_draws(self):
        engine.last_notes[:] = ['light "Spot": not carried']
        for panel in panels.classes:
            self.assertTrue(self.draw(panel), panel)
            if hasattr(panel, "draw_header"):
                panel.draw_header(types.SimpleNamespace(layout=Layout([])), self.context)
        self.assertIn("not carried", self.draw(panels.SLO_RT_PT_notes))
        self.assertEqual(self.draw(panels.SLO_RT_PT_light), ["brightness", "distance"])

    def test_own_values_and_missing_lights(self):
        self.material.slo_rt.use_own = True
        self.assertIn("reflectance", self.draw(panels.SLO_RT_PT_material))
        self.light.type = "SPOT"
        self.context.light = bpy.data.lights["Lamp"]
        self.assertEqual(self.draw(panels.SLO_RT_PT_light), ["slo-rt has no spot lights"])

    def test_preferences_say_what_is_found(self):
        drawn = []
        owner = types.SimpleNamespace(layout=Layout(drawn))
        owner.layout.prop = lambda *_: None
        preferences.SloRtPreferences.draw(owner, self.context)
        self.assertIn(blend.PROGRAM, drawn[-1])
        os.environ["SLO_RT"] = "/nowhere"
        preferences.SloRtPreferences.draw(owner, self.context)
        self.assertIn("There is no program /nowhere", drawn)

    def test_panels_of_blender_come_and_go(self):
        from bl_ui.properties_data_camera import DATA_PT_camera_dof
        from bl_ui.properties_output import RENDER_PT_format

        for panel in (DATA_PT_camera_dof, RENDER_PT_format):
            self.assertIn("SLO_RT", panel.COMPAT_ENGINES)
        slo_rt.unregister()
        self.assertNotIn("SLO_RT", RENDER_PT_format.COMPAT_ENGINES)
        self.assertFalse(hasattr(bpy.types.Scene, "slo_rt"))
        slo_rt.register()
