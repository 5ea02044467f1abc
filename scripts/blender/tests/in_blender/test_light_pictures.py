# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of physical light by the integrator PATH against those by Cycles.

Cycles' own shortcuts (clamps, blurred gloss, limits by kind of bounce) are off, so both renderers show
the same light. A picture is right if its mean is, and each block of 16 x 16 pixels, beyond the noise
of both.
"""

import os
import unittest

import bpy
import numpy as np

from . import blend
from .light_scenes import SCENES, start

BLOCK = 16
SIZE = (10 * BLOCK, 7 * BLOCK)
SAMPLES = int(os.environ.get("SLO_RT_SAMPLES", "128"))
MOST_OFF_IN_MEAN = 0.01
MOST_OFF_IN_BLOCK = 0.05
SIGMAS = 4.0  # of 70 blocks of three channels in 13 scenes, no sound one is farther off
FAINT = 0.02  # of the mean of a picture; what is darker has no error that anyone sees


def without_shortcuts(cycles):
    """Makes Cycles compute the same light as slo-rt."""
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.pixel_filter_type = "BOX"
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = cycles.light_sampling_threshold = 0.0
    cycles.max_bounces = 12
    for kind in ("diffuse", "glossy", "transmission"):
        setattr(cycles, f"{kind}_bounces", 12)
    cycles.transparent_max_bounces = 256


def rendered(scene, engine, seed, samples):
    """Linear colours (height, width, 3) of the scene by an engine, the bottom row first."""
    render = scene.render
    render.engine = engine
    scene.slo_rt.samples = scene.cycles.samples = samples
    scene.slo_rt.seed = scene.cycles.seed = seed
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth = "32"
    render.filepath = os.path.join(blend.FOLDER, f"light_{engine}.exr")
    bpy.ops.render.render(write_still=True)
    found = bpy.data.images.load(render.filepath)
    width, height = found.size
    pixels = np.empty(width * height * found.channels, np.float32)
    found.pixels.foreach_get(pixels)
    bpy.data.images.remove(found)
    return pixels.reshape(height, width, -1)[..., :3].astype(np.float64)


def blocks(pixels):
    """Means of blocks, (rows, columns, 3)."""
    height, width, _ = pixels.shape
    parts = pixels.reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, 3)
    return parts.mean(axis=(1, 3))


class Estimate:
    """A picture as the mean of two of other seeds, with the variance of the mean of its blocks."""

    def __init__(self, scene, engine, samples):
        first, second = (rendered(scene, engine, seed, samples) for seed in (1, 2))
        self.pixels = (first + second) / 2.0
        self.blocks = blocks(self.pixels)
        self.variance = blocks((first - second) ** 2) / (4.0 * BLOCK * BLOCK)


def compare(ours, theirs):
    """Returns `(mean of ours by that of theirs - 1, by how much the worst block is off beyond noise, its
    row, column and channel, the noise of a mean block)`."""
    off = np.abs(ours.blocks - theirs.blocks)
    noise = np.sqrt(ours.variance + theirs.variance)
    beyond = np.maximum(off - SIGMAS * noise, 0.0)
    floor = FAINT * theirs.pixels.mean()
    share = beyond / np.maximum(theirs.blocks, floor)
    worst = np.unravel_index(share.argmax(), share.shape)
    mean = ours.pixels.mean() / theirs.pixels.mean() - 1.0
    return mean, share[worst], worst, noise.mean() / theirs.pixels.mean()


class LightTest(unittest.TestCase):
    def test_as_in_cycles(self):
        blend.program()
        wanted = os.environ.get("SLO_RT_SCENES", "").split()
        for build in SCENES:
            if wanted and build.__name__ not in wanted:
                continue
            with self.subTest(build.__name__):
                scene = start(SIZE)
                build(scene)
                without_shortcuts(scene.cycles)
                ours = Estimate(scene, "SLO_RT", SAMPLES)
                theirs = Estimate(scene, "CYCLES", SAMPLES)
                self.keep(build.__name__, ours, theirs)
                mean, worst, place, noise = compare(ours, theirs)
                print(
                    f"  {build.__name__}: mean off by {100 * mean:+.2f} %, the worst block by "
                    f"{100 * worst:.2f} % beyond noise at {place}, noise {100 * noise:.2f} %"
                )
                self.assertGreater(theirs.pixels.mean(), 0.01)
                self.assertLess(abs(mean), MOST_OFF_IN_MEAN)
                self.assertLess(worst, MOST_OFF_IN_BLOCK)

    def keep(self, name, ours, theirs):
        """Keeps the pictures for whoever looks for the cause of a difference."""
        folder = os.environ.get("SLO_RT_PICTURES")
        if folder:
            path = os.path.join(folder, f"{name}.npz")
            np.savez(path, ours=ours.pixels, theirs=theirs.pixels)
