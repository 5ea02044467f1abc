# SPDX-License-Identifier: GPL-3.0-or-later
"""Curves through sampled motion. Knows nothing of Blender."""
