# SPDX-License-Identifier: GPL-3.0-or-later
"""Converts Blender's evaluated data to slo-rt."""
