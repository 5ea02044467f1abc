# SPDX-License-Identifier: GPL-3.0-or-later
"""Fits curves to sampled motion. Independent of Blender."""
