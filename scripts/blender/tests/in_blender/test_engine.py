# SPDX-License-Identifier: GPL-3.0-or-later
"""F12: the engine, the program, and failures."""

import os
import stat
import subprocess
import unittest
from unittest import mock

import bpy
import numpy as np

from slo_rt import engine, exports

from . import blend


def result_pixels(scene):
    """Renders and returns linear pixels (height, width, 3), through an EXR file."""
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.filepath = os.path.join(blend.FOLDER, "result.exr")
    bpy.ops.render.render(write_still=True)
    return engine.linear_pixels(scene.render.filepath)[..., :3]


def false_program(body):
    """Returns the path of a program that calls itself slo-rt and runs the shell lines of `body`."""
    path = os.path.join(blend.FOLDER, f"slo-rt-{abs(hash(body))}")
    with open(path, "w", encoding="utf-8") as file:
        file.write(
            "#!/bin/sh\ncase $1 in --version) echo slo-rt 9.9; exit;; --help) echo; exit;; esac\n"
            + body
        )
    os.chmod(path, os.stat(path).st_mode | stat.S_IXUSR)
    return path


class EngineTest(unittest.TestCase):
    def setUp(self):
        self.scene = blend.fresh_scene((80, 60))
        os.environ["SLO_RT"] = blend.PROGRAM

    def test_default_cube(self):
        bpy.ops.wm.read_factory_settings()
        scene = bpy.context.scene
        scene.render.engine = "SLO_RT"
        scene.render.resolution_x, scene.render.resolution_y = 160, 120
        scene.slo_rt.samples = 16
        pixels = result_pixels(scene).mean(axis=2)
        background = pixels[5, 5]
        self.assertAlmostEqual(background, 0.05087609, places=5)
        cube = np.abs(pixels - background) > 0.005
        self.assertGreater(cube.mean(), 0.1)
        self.assertLess(cube.mean(), 0.2)
        levels = np.unique(np.round(pixels[cube], 2))
        self.assertGreater(len(levels), 3)

    def test_values_are_those_of_the_program(self):
        blend.cube().rotation_euler = (0.3, 0.4, 0.5)
        lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", "POINT"))
        lamp.location, lamp.data.energy = (3.0, -5.0, 5.0), 9000.0
        self.scene.collection.objects.link(lamp)
        shown = result_pixels(self.scene)
        path = os.path.join(blend.FOLDER, "same.txt")
        exports.export_scene(
            self.scene, self.scene.view_layers[0], path, 1, 1, "same_", "EXR_IMAGE"
        )
        subprocess.run(
            [blend.PROGRAM, "-q", "-s", path, "-f", "1", "-od", blend.FOLDER], check=True,
            stdout=subprocess.DEVNULL,
        )  # fmt: skip
        written = engine.linear_pixels(os.path.join(blend.FOLDER, "same_00001.exr"))[..., :3]
        self.assertGreater(written.max(), 1.0)
        np.testing.assert_array_equal(shown, written)

    def test_border_is_a_part_of_the_picture(self):
        blend.cube()
        whole = result_pixels(self.scene)
        render = self.scene.render
        render.use_border = render.use_crop_to_border = True
        render.border_min_x, render.border_max_x = 0.25, 0.75
        render.border_min_y, render.border_max_y = 0.5, 1.0
        np.testing.assert_array_equal(result_pixels(self.scene), whole[30:, 20:60])
        render.use_crop_to_border = False
        pixels = result_pixels(self.scene)
        np.testing.assert_array_equal(pixels[30:, 20:60], whole[30:, 20:60])
        self.assertEqual(pixels[:30].max(), 0.0)

    def test_animation(self):
        thing = blend.cube()
        blend.key(thing, "location", 1, (-2.0, 0.0, 0.0))
        blend.key(thing, "location", 3, (2.0, 0.0, 0.0))
        self.scene.render.use_motion_blur = True
        self.scene.frame_end = 3
        self.scene.render.filepath = os.path.join(blend.FOLDER, "move_")
        bpy.ops.render.render(animation=True)
        centers = []
        for frame in (1, 2, 3):
            path = os.path.join(blend.FOLDER, f"move_{frame:04d}.png")
            pixels = engine.linear_pixels(path)[..., :3].mean(axis=2)
            light = np.abs(pixels - pixels[2, 2])
            centers.append((light.sum(axis=0) * np.arange(80)).sum() / light.sum())
        self.assertLess(centers[0] + 5.0, centers[1])
        self.assertLess(centers[1] + 5.0, centers[2])

    def test_missing_program(self):
        os.environ["SLO_RT"] = "/nowhere/slo-rt"
        with self.assertRaisesRegex(
            RuntimeError, "There is no program /nowhere/slo-rt.*Preferences"
        ):
            bpy.ops.render.render()

    def test_another_program(self):
        os.environ["SLO_RT"] = "/bin/echo"
        with self.assertRaisesRegex(RuntimeError, "is not slo-rt"):
            bpy.ops.render.render()

    def test_errors_of_the_program_are_shown(self):
        os.environ["SLO_RT"] = false_program(
            "echo 'error: frame.txt:3:7: no such thing' >&2; exit 65"
        )
        with self.assertRaisesRegex(RuntimeError, "frame.txt:3:7: no such thing"):
            bpy.ops.render.render()

    def test_escape_stops_and_keeps_what_was_saved(self):
        script = (
            'while [ $# -gt 0 ]; do [ "$1" = --outdir ] && out=$2; shift; done\n'
            "trap 'echo half >\"$out/frame.checkpoint\"; exit 75' INT\n"
            "while :; do sleep 0.05; done\n"
        )
        os.environ["SLO_RT"] = false_program(script)
        with mock.patch.object(engine.SloRtRenderEngine, "_should_stop", lambda self: True):
            bpy.ops.render.render()
        kept = os.path.join(blend.work_folder(), "frame.checkpoint")
        self.assertTrue(os.path.exists(kept))
        os.remove(kept)

    def test_escape_stops_the_real_program(self):
        blend.cube()
        self.scene.slo_rt.samples = 600
        whole = result_pixels(self.scene)
        left = iter([False] * 3)
        with mock.patch.object(
            engine.SloRtRenderEngine, "_should_stop", lambda self: next(left, True)
        ):
            bpy.ops.render.render()
        folder = blend.work_folder()
        states = [name for name in os.listdir(folder) if name.endswith(".state")]
        print("  kept:", states)
        np.testing.assert_array_equal(result_pixels(self.scene), whole)

    def test_pictures_come_early_and_progress_rises(self):
        blend.cube()
        self.scene.slo_rt.samples = 64
        shown, fractions = [], []
        whole_show = engine.SloRtRenderEngine._show

        def show(self, run, depsgraph):
            shown.append(engine.linear_pixels(run.picture)[..., 0])
            whole_show(self, run, depsgraph)

        with (
            mock.patch.object(engine.SloRtRenderEngine, "_shows_early", lambda self, values: True),
            mock.patch.object(engine.SloRtRenderEngine, "_show", show),
            mock.patch.object(
                engine.SloRtRenderEngine, "_show_progress",
                lambda self, fraction, samples: fractions.append(fraction),
            ),
        ):  # fmt: skip
            last = result_pixels(self.scene)
        self.assertEqual(len(shown), 3)
        np.testing.assert_array_equal(shown[-1], last[..., 0])
        np.testing.assert_array_equal(result_pixels(self.scene), last)
        self.assertTrue(all(0.0 <= fraction <= 1.0 for fraction in fractions))

    def test_a_preview_comes_first(self):
        """A preview by photons has the light of the whole picture, for both integrators that need it."""
        blend.cube()
        bpy.ops.mesh.primitive_plane_add(size=20.0, location=(0.0, 0.0, -1.0))
        blend.lamp(energy=2000.0).data.shadow_soft_size = 0.2
        values = self.scene.slo_rt
        values.samples, values.show_preview = 64, True
        whole_show = engine.SloRtRenderEngine._show
        for integrator in ("PATH", "PHOTON_MAP"):
            values.integrator = integrator
            shown = []

            def show(self, run, depsgraph, shown=shown):
                shown.append((type(run), engine.linear_pixels(run.picture)[..., :3]))
                whole_show(self, run, depsgraph)

            with (
                mock.patch.object(engine.SloRtRenderEngine, "_is_watched", lambda self: True),
                mock.patch.object(engine.SloRtRenderEngine, "_show", show),
            ):
                last = result_pixels(self.scene)
            self.assertEqual(
                [kind is engine.Preview for kind, _ in shown], [True, False, False, False]
            )
            np.testing.assert_array_equal(shown[-1][1], last)
            self.assertGreater(last.mean(), 0.01)
            self.assertAlmostEqual(shown[0][1].mean() / last.mean(), 1.0, delta=0.1)

    def test_time_limit_takes_fewer_samples(self):
        blend.cube()
        self.scene.slo_rt.samples, self.scene.slo_rt.time = 65535, 2.0
        used = []
        whole_run = engine.SloRtRenderEngine._run

        def run(self, how, samples, all_samples):
            used.append(samples)
            return whole_run(self, how, samples, all_samples)

        with mock.patch.object(engine.SloRtRenderEngine, "_run", run):
            bpy.ops.render.render()
        self.assertEqual(used[0], 1)
        self.assertEqual(used, sorted(used))
        self.assertLess(used[-1], 65535)

    def test_meshes_are_not_written_twice(self):
        blend.cube()
        bpy.ops.render.render()
        folder = os.path.join(blend.work_folder(), "frame")
        before = {
            name: os.stat(os.path.join(folder, name)).st_mtime_ns for name in os.listdir(folder)
        }
        bpy.ops.render.render()
        after = {
            name: os.stat(os.path.join(folder, name)).st_mtime_ns for name in os.listdir(folder)
        }
        self.assertEqual(before, after)

    def test_textures_are_written_when_they_change(self):
        tree = blend.paint(blend.cube()).id_data
        image = bpy.data.images.new("Picture", 64, 64)
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = image
        tree.links.new(node.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])
        folder = os.path.join(blend.work_folder(), "frame")

        def texture():
            bpy.ops.render.render()
            names = [name for name in os.listdir(folder) if name.endswith(".png")]
            self.assertEqual(len(names), 1)
            return names[0], os.stat(os.path.join(folder, names[0])).st_mtime_ns

        def paint():
            image.pixels[4 * 2000] = 0.5

        def save():
            image.filepath_raw, image.file_format = os.path.join(blend.FOLDER, "p.png"), "PNG"
            image.save()

        def reload():
            other = image.copy()
            other.pixels[4 * 1000 + 1] = 0.25
            other.filepath_raw, other.file_format = image.filepath_raw, "PNG"
            other.save()
            image.reload()

        seen = [texture()]
        for change, is_other in (
            (paint, True),
            (save, False),
            (reload, True),
            (lambda: setattr(image.colorspace_settings, "name", "Non-Color"), True),
            (lambda: image.pixels.__setitem__(4 * 7 + 3, 0.0), True),
            (lambda: image.pack(), False),
        ):
            change()
            seen.append(texture())
            self.assertEqual(seen[-1] != seen[-2], is_other, change)
            self.assertEqual(texture(), seen[-1])
        self.assertIn("the transparency of an image is not carried", "".join(engine.last_notes))

    def test_meshes_of_other_frames_are_removed(self):
        thing = blend.cube()
        bpy.ops.render.render()
        thing.data.vertices[0].co.x -= 1.0
        bpy.ops.render.render()
        folder = os.path.join(blend.work_folder(), "frame")
        self.assertEqual(len([name for name in os.listdir(folder) if name.endswith(".slo")]), 1)

    def test_each_view_layer_has_its_picture_and_its_folder(self):
        names = [self.scene.view_layers[0].name, "Second"]
        self.scene.view_layers.new("Second")
        for name, x in zip(names, (-2.0, 2.0)):
            inner = bpy.data.collections.new(name)
            self.scene.collection.children.link(inner)
            thing = blend.cube(f"Cube of {name}")
            thing.location.x = x
            for old in list(thing.users_collection):
                old.objects.unlink(thing)
            inner.objects.link(thing)
            for layer in self.scene.view_layers:
                layer.layer_collection.children[name].exclude = layer.name != name
        bpy.ops.render.render()
        folders = [engine.work_folder(self.scene.name, name) for name in names]
        self.assertNotEqual(*folders)
        for folder, name in zip(folders, names):
            with open(os.path.join(folder, "frame.txt"), encoding="utf-8") as file:
                text = file.read()
            for other in names:
                self.assertEqual(f"mesh Cube_of_{other}" in text, other == name)
        text = blend.export_text()
        self.assertIn(f"mesh Cube_of_{names[0]}", text)
        self.assertNotIn("mesh Cube_of_Second", text)

    def test_both_views_of_stereo_have_the_picture(self):
        blend.cube()
        render = self.scene.render
        render.filepath = os.path.join(blend.FOLDER, "view.png")
        bpy.ops.render.render(write_still=True)
        render.use_multiview = True
        render.image_settings.views_format = "INDIVIDUAL"
        bpy.ops.render.render(write_still=True)
        pictures = []
        for view in ("", "_L", "_R"):
            path = os.path.join(blend.FOLDER, f"view{view}.png")
            pictures.append(engine.linear_pixels(path)[..., :3])
        self.assertGreater(pictures[0].max(), 0.05)
        np.testing.assert_array_equal(pictures[1], pictures[0])
        np.testing.assert_array_equal(pictures[2], pictures[0])

    def test_frames_below_zero(self):
        thing = blend.cube()
        blend.key(thing, "location", -9, (-2.0, 0.0, 0.0))
        blend.key(thing, "location", -1, (2.0, 0.0, 0.0))
        blend.lamp()
        self.scene.frame_start, self.scene.frame_end = -9, -1
        self.scene.frame_set(-3)
        self.assertGreater(np.ptp(result_pixels(self.scene)), 0.1)

    def test_borders_fall_on_blenders_pixels(self):
        blend.cube()
        self.scene.render.resolution_percentage = 57
        render = self.scene.render
        whole = result_pixels(self.scene)
        self.assertEqual(whole.shape, (34, 45, 3))
        render.use_border = render.use_crop_to_border = True
        for low, high in ((0.1, 0.7), (0.3, 0.9), (0.0, 0.6)):
            render.border_min_x = render.border_min_y = low
            render.border_max_x = render.border_max_y = high
            part = result_pixels(self.scene)
            left, bottom = (int(np.float32(low) * np.float32(n)) for n in (45, 34))
            height, width = part.shape[:2]
            np.testing.assert_array_equal(
                part, whole[bottom : bottom + height, left : left + width]
            )

    def test_the_line_above_the_picture_says_that_there_is_no_light(self):
        blend.cube()
        lines, whole_info = [], engine.SloRtRenderEngine._info

        def info(self, fraction, samples):
            lines.append(whole_info(self, fraction, samples))
            return lines[-1]

        with mock.patch.object(engine.SloRtRenderEngine, "_info", info):
            bpy.ops.render.render()
            self.assertIn("No light, 4 samples, 0 %", lines)
            lines.clear()
            blend.lamp()
            bpy.ops.render.render()
        self.assertIn("4 samples, 0 %", lines)
        self.assertNotIn("No light", "".join(lines))

    def test_a_crash_in_the_middle_of_a_frame_is_told_with_its_place(self):
        os.environ["SLO_RT"] = false_program(
            'echo \'{"event":"progress","fraction":0.5}\' >&2; kill -SEGV $$'
        )
        self.scene.frame_set(7)
        with self.assertRaisesRegex(RuntimeError, "SIGSEGV\n.frame 7 of scene .*frame.txt"):
            bpy.ops.render.render()

    def test_files_go_when_the_extension_goes(self):
        bpy.ops.render.render()
        folder = os.path.dirname(blend.work_folder())
        self.assertTrue(os.path.isdir(folder))
        engine.remove_work_folders()
        self.assertFalse(os.path.exists(folder))
        bpy.ops.render.render()

    def test_what_is_lost_is_listed(self):
        blend.lamp("Spot", "SPOT")
        bpy.ops.render.render()
        dark = "scene: there is no light for slo-rt: surfaces are as bright as the world is"
        self.assertEqual(engine.last_notes, ['light "Spot": spot lights are not carried', dark])
