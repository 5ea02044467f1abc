# SPDX-License-Identifier: GPL-3.0-or-later
"""slo-rt in Blender: a render engine, and export of scenes, animations and meshes.

`format`, `fit`, `passes`, `process`, `program` and `report` do not depend on Blender; `convert`
reads its evaluated data; the other modules are called by Blender.
"""


def register():
    """Called by Blender when the extension is switched on."""
    import bpy

    from . import operators, panels, properties

    for cls in _classes():
        bpy.utils.register_class(cls)
    properties.attach()
    bpy.types.TOPBAR_MT_file_export.append(operators.draw_export_menu)
    panels.join_shared_panels()


def unregister():
    """Called by Blender when the extension is switched off."""
    import bpy

    from . import engine, operators, panels, properties

    engine.remove_work_folders()
    panels.leave_shared_panels()
    bpy.types.TOPBAR_MT_file_export.remove(operators.draw_export_menu)
    properties.detach()
    for cls in reversed(_classes()):
        bpy.utils.unregister_class(cls)


def _classes():
    from . import engine, operators, panels, preferences, properties

    modules = (preferences, properties, engine, operators, panels)
    return [cls for module in modules for cls in module.classes]
