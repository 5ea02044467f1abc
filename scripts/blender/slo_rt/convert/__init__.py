# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's evaluated data becomes in slo-rt."""
