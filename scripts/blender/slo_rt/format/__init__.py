# SPDX-License-Identifier: GPL-3.0-or-later
"""The files of slo-rt: scene text, meshes, textures, names. Independent of Blender."""
