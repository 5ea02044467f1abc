# SPDX-License-Identifier: GPL-3.0-or-later
"""Whatever an artist switches on either changes the exported scene or is listed."""

import hashlib
import os
import unittest

import bpy
import numpy as np

from .. import scene_reader
from . import blend

CHANGES = ""  # instead of words of the report: the files change


def exported():
    """`(text without comments and a hash of all other files, the report's lines)`."""
    path = blend.export()
    with open(path, encoding="utf-8") as file:
        lines = file.read().splitlines()
    hasher = hashlib.blake2b()
    folder = os.path.splitext(path)[0]
    for name in sorted(os.listdir(folder)):
        with open(os.path.join(folder, name), "rb") as file:
            hasher.update(name.encode() + file.read())
    comments = [line for line in lines if line.startswith("#")]
    text = "\n".join(line for line in lines if not line.startswith("#"))
    return text + hasher.hexdigest(), comments


def geometry_nodes(thing, *kinds):
    """Adds what nodes of these kinds make to the geometry of an object."""
    group = bpy.data.node_groups.new("More", "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    nodes, links = group.nodes, group.links
    join = nodes.new("GeometryNodeJoinGeometry")
    links.new(nodes.new("NodeGroupInput").outputs[0], join.inputs[0])
    for kind in kinds:
        links.new(nodes.new(kind).outputs[0], join.inputs[0])
    links.new(join.outputs[0], nodes.new("NodeGroupOutput").inputs[0])
    thing.modifiers.new("More", "NODES").node_group = group
    return group


def instances_by_nodes(f):
    group = geometry_nodes(f.cube)
    nodes, links = group.nodes, group.links
    spread = nodes.new("GeometryNodeInstanceOnPoints")
    grid, ball = nodes.new("GeometryNodeMeshGrid"), nodes.new("GeometryNodeMeshIcoSphere")
    links.new(grid.outputs[0], spread.inputs["Points"])
    links.new(ball.outputs[0], spread.inputs["Instance"])
    join = next(node for node in nodes if node.type == "JOIN_GEOMETRY")
    links.new(spread.outputs[0], join.inputs[0])


def instances_of_a_collection(f):
    inner = bpy.data.collections.new("Inner")
    ball = bpy.data.objects.new("Ball", f.cube.data)
    inner.objects.link(ball)
    empty = bpy.data.objects.new("Empty", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", inner
    empty.location.x = 4.0
    f.scene.collection.objects.link(empty)


def particles(render_type, kind="EMITTER"):
    def add(f):
        f.cube.modifiers.new("Many", "PARTICLE_SYSTEM")
        settings = f.cube.particle_systems[0].settings
        settings.type, settings.count = kind, 20
        settings.render_type = render_type
        if render_type == "OBJECT":
            settings.instance_object = blend.cube("Grain", 0.1)
        settings.frame_end = 1

    return add


def hair_curves(f):
    data = bpy.data.hair_curves.new("Hair")
    data.add_curves([3])
    f.scene.collection.objects.link(bpy.data.objects.new("Hair", data))


def point_cloud(f):
    bpy.ops.object.pointcloud_random_add()


def compositor(f):
    if bpy.app.version < (5, 0, 0):
        f.scene.use_nodes = True
    else:
        group = bpy.data.node_groups.new("Compositor", "CompositorNodeTree")
        group.nodes.new("CompositorNodeBlur")
        f.scene.compositing_node_group = group


def strip(f):
    editor = f.scene.sequence_editor_create()
    strips = editor.strips if hasattr(editor, "strips") else editor.sequences
    kind = {"frame_end" if bpy.app.version < (5, 0, 0) else "length": 20}
    strips.new_effect("Color", "COLOR", channel=1, frame_start=1, **kind)


def adaptive_subdivision(f):
    modifier = f.cube.modifiers.new("S", "SUBSURF")
    owner = modifier if hasattr(modifier, "use_adaptive_subdivision") else f.cube.cycles
    owner.use_adaptive_subdivision = True


def rigid_body(f):
    bpy.context.view_layer.objects.active = f.cube
    bpy.ops.rigidbody.object_add()


def dynamic_paint(f):
    bpy.context.view_layer.objects.active = f.cube
    f.cube.modifiers.new("D", "DYNAMIC_PAINT")
    bpy.ops.dpaint.type_toggle(type="CANVAS")
    surface = f.cube.modifiers["D"].canvas_settings.canvas_surfaces.active
    surface.surface_type = "WAVE"


def fluid(f):
    modifier = f.cube.modifiers.new("F", "FLUID")
    modifier.fluid_type = "DOMAIN"


def simulation(f):
    group = geometry_nodes(f.cube)
    start = group.nodes.new("GeometryNodeSimulationInput")
    end = group.nodes.new("GeometryNodeSimulationOutput")
    start.pair_with_output(end)
    group.links.new(start.outputs["Geometry"], end.inputs["Geometry"])
    join = next(node for node in group.nodes if node.type == "JOIN_GEOMETRY")
    group.links.new(end.outputs["Geometry"], join.inputs[0])


def curve(f):
    bpy.ops.curve.primitive_bezier_circle_add(location=(3.0, 0.0, 0.0))
    bpy.context.object.data.bevel_depth = 0.2


def armature(f):
    bpy.ops.object.armature_add()
    bones = bpy.context.object
    bpy.context.view_layer.objects.active = f.cube
    f.cube.modifiers.new("Bones", "ARMATURE").object = bones
    group = f.cube.vertex_groups.new(name="Bone")
    group.add(range(8), 1.0, "REPLACE")
    bone = bones.pose.bones["Bone"]
    for frame, angle in ((1, 0.0), (10, 1.0), (25, 0.0)):
        bone.rotation_quaternion = (1.0, angle, 0.0, 0.0)
        bone.keyframe_insert("rotation_quaternion", frame=frame)


def shape_key_for_a_moment(f):
    f.cube.shape_key_add(name="Basis")
    key = f.cube.shape_key_add(name="Fat")
    key.data[0].co.x += 1.0
    for frame, value in ((1, 0.0), (8, 0.0), (9, 1.0), (10, 0.0), (25, 0.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)


def animated_world(f):
    socket = f.scene.world.node_tree.nodes["Background"].inputs["Strength"]
    for frame, value in ((1, 1.0), (25, 2.0)):
        socket.default_value = value
        socket.keyframe_insert("default_value", frame=frame)


def animated_material(f):
    socket = f.shader.inputs["Roughness"]
    for frame, value in ((1, 0.5), (25, 1.0)):
        socket.default_value = value
        socket.keyframe_insert("default_value", frame=frame)


def mixed(first, second, factor=None):
    """The surface as a mix of two shaders; `factor` is a kind of node."""

    def add(f):
        tree = f.shader.id_data
        nodes, links = tree.nodes, tree.links
        output = tree.get_output_node("ALL")
        mix = nodes.new("ShaderNodeMixShader")
        for i, kind in ((1, first), (2, second)):
            node = nodes.new(kind) if kind else f.shader
            links.new(node.outputs[0], mix.inputs[i])
        links.new(mix.outputs[0], output.inputs["Surface"])
        if factor:
            links.new(nodes.new(factor).outputs[0], mix.inputs[0])

    return add


def node_on(socket, kind, output=0):
    """A node on a socket of the material's shader or output."""

    def add(f):
        tree = f.shader.id_data
        owner = f.shader if socket in f.shader.inputs else tree.get_output_node("ALL")
        tree.links.new(tree.nodes.new(kind).outputs[output], owner.inputs[socket])

    return add


def surface(kind):
    def add(f):
        tree = f.shader.id_data
        output = tree.get_output_node("ALL")
        tree.links.new(tree.nodes.new(kind).outputs[0], output.inputs["Surface"])

    return add


def emission(f):
    f.shader.inputs["Emission Strength"].default_value = 2.0


def textured(**values):
    """An image with these values as base colour."""

    def add(f):
        image = bpy.data.images.new("Picture", 4, 4, float_buffer="is_float" in values)
        for name, value in values.items():
            if name == "pixel":
                image.pixels[0] = value
            elif name != "is_float":
                setattr(image, name, value)
        tree = f.shader.id_data
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = image
        tree.links.new(node.outputs["Color"], f.shader.inputs["Base Color"])

    return add


def light(kind, **values):
    """A light of a kind, with values for its data."""

    def add(f):
        data = blend.lamp("More", kind).data
        for name, value in values.items():
            if name == "is_portal":
                data.cycles.is_portal = value
            else:
                setattr(data, name, value)

    return add


def holdout_of_a_collection(f):
    inner = bpy.data.collections.new("Inner")
    f.scene.collection.children.link(inner)
    inner.objects.link(f.cube)
    f.layer.layer_collection.children["Inner"].holdout = True


def light_linking(f):
    f.lamp.light_linking.receiver_collection = bpy.data.collections.new("Lit")


def material_override(f):
    blend.paint(f.cube, "Override", Roughness=0.1)
    f.layer.material_override = f.cube.data.materials.pop()


def world_override(f):
    world = f.scene.world.copy()
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = 3.0
    f.layer.world_override = world


def other_view_layer(f):
    f.scene.view_layers.new("Second")


def markers(f):
    other = bpy.data.objects.new("Second", f.scene.camera.data)
    f.scene.collection.objects.link(other)
    f.scene.timeline_markers.new("Cut", frame=10).camera = other


def hidden_collection(f):
    inner = bpy.data.collections.new("Inner")
    f.scene.collection.children.link(inner)
    inner.objects.link(f.cube)
    for other in set(f.cube.users_collection) - {inner}:
        other.objects.unlink(f.cube)
    f.layer.layer_collection.children["Inner"].exclude = True


def sets(path, value):
    """Sets what a path from the frame's things leads to, such as `cube.is_holdout`."""

    def add(f):
        owner, _, name = path.rpartition(".")
        target = f
        for step in owner.split("."):
            target = getattr(target, step)
        setattr(target, name, value)

    return add


def moving(path, **values):
    """Sets values while the cube moves and the shutter is open."""

    def add(f):
        blend.key(f.cube, "location", 1, (0.0, 0.0, 0.0))
        blend.key(f.cube, "location", 25, (1.0, 0.0, 0.0))
        f.scene.render.use_motion_blur = True
        if path:
            sets(path, values["value"])(f)

    return add


FEATURES = {
    # Particles, instances, kinds of objects
    "hair": (particles("PATH", "HAIR"), "hair not carried"),
    "particles as halos": (particles("HALO"), "particles as halos not carried"),
    "particles as lines": (particles("LINE"), "particles as lines not carried"),
    "particles as objects": (particles("OBJECT"), CHANGES),
    "instances by geometry nodes": (instances_by_nodes, CHANGES),
    "instances of a collection": (instances_of_a_collection, CHANGES),
    "volume by geometry nodes": (
        lambda f: geometry_nodes(f.cube, "GeometryNodeVolumeCube"), "volume objects",
    ),
    "points by geometry nodes": (
        lambda f: geometry_nodes(f.cube, "GeometryNodePoints"), "pointcloud objects",
    ),
    "curve": (curve, CHANGES),
    "text": (lambda f: bpy.ops.object.text_add(location=(3.0, 0.0, 0.0)), CHANGES),
    "metaball": (lambda f: bpy.ops.object.metaball_add(location=(3.0, 0.0, 0.0)), CHANGES),
    "surface": (
        lambda f: bpy.ops.surface.primitive_nurbs_surface_sphere_add(location=(3.0, 0.0, 0.0)),
        CHANGES,
    ),
    "hair curves": (hair_curves, "curves objects"),
    "point cloud": (point_cloud, "pointcloud objects"),
    "grease pencil": (lambda f: bpy.ops.object.grease_pencil_add(type="STROKE"), "grease"),
    # Visibility
    "holdout": (sets("cube.is_holdout", True), "a holdout in Blender"),
    "holdout of a collection": (holdout_of_a_collection, "a holdout in Blender"),
    "shadow catcher": (sets("cube.is_shadow_catcher", True), "a shadow catcher"),
    **{
        f"hidden from {ray} rays": (
            sets(f"cube.visible_{ray}", False), f"hidden from {ray} rays",
        )
        for ray in ("camera", "diffuse", "glossy", "transmission", "shadow")
    },
    "light linking": (light_linking, "light linking is not carried"),
    "hidden collection": (hidden_collection, CHANGES),
    # Shape and time
    "subdivision for rendering": (
        lambda f: setattr(f.cube.modifiers.new("S", "SUBSURF"), "render_levels", 1), CHANGES,
    ),
    "flattened": (lambda f: setattr(f.cube, "scale", (1.0, 1.0, 0.0)), CHANGES),
    "scaled to nothing": (
        lambda f: setattr(f.cube, "scale", (0.0, 0.0, 0.0)), "scaled to nothing and left out",
    ),
    "scaled to a line": (
        lambda f: setattr(f.cube, "scale", (1.0, 0.0, 0.0)), "scaled to nothing and left out",
    ),
    "shape key for a moment": (shape_key_for_a_moment, CHANGES),
    "armature": (armature, CHANGES),
    "world that changes": (animated_world, 'world "World": its changes over time'),
    "material that changes": (animated_material, 'material "Paint": its changes over time'),
    "scene that changes": (
        lambda f: f.scene.keyframe_insert("slo_rt.samples", frame=1),
        'scene "Scene": its changes over time',
    ),
    "motion": (moving(""), CHANGES),
    "no blur of a view layer": (moving("layer.use_motion_blur", value=False), CHANGES),
    "no blur of an object": (moving("cube.cycles.use_motion_blur", value=False), "not blurred"),
    # Surfaces
    "hole": (surface("ShaderNodeBsdfTransparent"), CHANGES),
    "material as holdout": (surface("ShaderNodeHoldout"), "Holdout is not carried"),
    "metallic": (surface("ShaderNodeBsdfMetallic"), "of the Metallic BSDF"),
    "toon": (surface("ShaderNodeBsdfToon"), "Toon BSDF is not carried"),
    "transparent mix": (
        mixed("ShaderNodeBsdfTransparent", None, "ShaderNodeTexNoise"),
        "Mix Shader is not carried, one of its",
    ),
    "half transparent": (mixed("ShaderNodeBsdfTransparent", None), CHANGES),
    "glow": (emission, "shines by itself"),
    "displacement": (node_on("Displacement", "ShaderNodeDisplacement"), "displacement is not"),
    "volume of a material": (
        node_on("Volume", "ShaderNodeVolumePrincipled"), "volume is not carried",
    ),
    "procedural colour": (node_on("Base Color", "ShaderNodeTexNoise"), "is not carried, the"),
    "generated image": (textured(), CHANGES),
    "float image": (textured(is_float=True, pixel=7.0), "values below 0 and above 1"),
    "image of not a number": (textured(is_float=True, pixel=float("nan")), "no finite number"),
    "tiles": (textured(source="TILED"), "only the first picture"),
    "missing image": (
        textured(source="FILE", filepath="/nowhere/x.png"), "can't be read",
    ),
    # Lights
    "spot": (light("SPOT"), "spot lights are not carried"),
    "sun": (light("SUN", angle=0.1), "a sun without size"),
    "disk": (light("AREA", shape="DISK"), "round area light"),
    "ellipse": (light("AREA", shape="ELLIPSE"), "round area light"),
    "spread": (light("AREA", spread=1.0), "whatever its spread"),
    "portal": (light("AREA", is_portal=True), "portals are not carried"),
    "ball of light": (light("POINT", shadow_soft_size=1.0), "its radius is not carried"),
    "flat area light": (
        lambda f: setattr(blend.lamp("More", "AREA"), "scale", (1.0, 0.0, 1.0)),
        'light "More": is scaled to nothing',
    ),
    "no light": (lambda f: bpy.data.objects.remove(f.lamp), "there is no light for slo-rt"),
    # World
    "colour of the world": (sets("background.default_value", (1.0, 0.0, 0.0, 1.0)), CHANGES),
    "world for no camera": (
        sets("scene.world.cycles_visibility.camera", False), "hidden from camera rays",
    ),
    # Camera
    "clip start": (sets("camera.clip_start", 9.5), "before its clip start, 9.5 m"),
    "clip end": (sets("camera.clip_end", 10.5), "behind its clip end, 10.5 m"),
    "shift": (sets("camera.shift_x", 0.1), "the shift of the lens"),
    "panorama": (sets("camera.type", "PANO"), "a panorama"),
    "orthographic": (sets("camera.type", "ORTHO"), "orthographic"),
    "wide pixels": (sets("scene.render.pixel_aspect_x", 2.0), "less at its sides"),
    "high pixels": (sets("scene.render.pixel_aspect_y", 2.0), "more at its sides"),
    "markers": (markers, CHANGES),
    # View layers and rendering
    "material override": (material_override, CHANGES),
    "world override": (world_override, CHANGES),
    "no surfaces": (sets("layer.use_solid", False), CHANGES),
    "no sky": (sets("layer.use_sky", False), CHANGES),
    "passes": (sets("layer.use_pass_z", True), "only the picture, not its passes"),
    "other view layers": (other_view_layer, 'is here, and not \'Second\''),
    "frame step": (sets("scene.frame_step", 3), "renders one of 3"),
    "view transform": (sets("view.view_transform", "AgX"), "view transform AgX"),
    "exposure": (sets("view.exposure", 1.0), "exposure 1.0"),
    "gamma": (sets("view.gamma", 2.0), "gamma 2.0"),
    "transparent film": (sets("scene.render.film_transparent", True), "not transparent"),
    "Freestyle": (sets("scene.render.use_freestyle", True), "Freestyle"),
    "render border": (sets("scene.render.use_border", True), "the render border is not carried"),
    "stereo": (sets("scene.render.use_multiview", True), "one view is rendered, not two"),
    "metadata in the picture": (sets("scene.render.use_stamp", True), "metadata is not drawn"),
    "compositor": (compositor, "the compositor's nodes are not carried"),
    "sequencer": (strip, "the video sequencer's strips are not carried"),
    "display": (sets("scene.display_settings.display_device", "Display P3"), "display Display P3"),
    "passes of Cycles": (
        sets("layer.cycles.denoising_store_passes", True), "only the picture, not its passes",
    ),
    "adaptive subdivision": (adaptive_subdivision, "adaptive subdivision is not carried"),
    # Physics without a bake
    "cloth": (lambda f: f.cube.modifiers.new("C", "CLOTH"), "its cloth is not baked"),
    "soft body": (lambda f: f.cube.modifiers.new("S", "SOFT_BODY"), "its soft body is not baked"),
    "rigid body": (rigid_body, "its rigid body is not baked"),
    "particle physics": (particles("HALO"), "its particle system is not baked"),
    "dynamic paint": (dynamic_paint, "its dynamic paint is not baked"),
    "fluid": (fluid, "its fluid is not baked"),
    "simulation nodes": (simulation, "unless its simulation of geometry nodes is baked"),
    "percentage": (sets("scene.render.resolution_percentage", 57), CHANGES),
}  # fmt: skip


# What differs with the integrator PATH.
PHYSICAL = {
    "metallic": CHANGES,
    "glow": CHANGES,
    "float image": CHANGES,
    "spot": CHANGES,
    "sun": CHANGES,
    "disk": CHANGES,
    "ellipse": CHANGES,
    "ball of light": "its soft falloff",
    "no light": CHANGES,  # the world shines
    "world for no camera": CHANGES,
    "view transform": CHANGES,
    "exposure": CHANGES,
}


class Frame:
    """A scene of a cube, a light and a camera that can be exported completely."""

    def __init__(self, integrator="DISTRIBUTED"):
        self.scene = blend.fresh_scene(integrator=integrator)
        self.layer = self.scene.view_layers[0]
        self.view = self.scene.view_settings
        self.camera = self.scene.camera.data
        self.cube = blend.cube()
        self.shader = blend.paint(self.cube)
        self.lamp = blend.lamp()

    @property
    def background(self):
        """The colour of the world."""
        return self.scene.world.node_tree.nodes["Background"].inputs["Color"]


class FeatureTest(unittest.TestCase):
    def test_each_feature_changes_the_scene_or_is_listed(self):
        self.check("DISTRIBUTED", {})

    def test_each_feature_is_in_a_physical_scene_or_is_listed(self):
        self.check("PATH", PHYSICAL)

    def check(self, integrator, differences):
        Frame(integrator)
        plain, comments = exported()
        self.assertEqual(len(comments), 1, comments)
        for name, (add, words) in FEATURES.items():
            words = differences.get(name, words)
            with self.subTest(name):
                frame = Frame(integrator)
                if name.startswith("no blur of a view"):
                    moving("")(frame)
                    before = exported()[0]
                    frame.layer.use_motion_blur = False
                else:
                    before = plain
                    add(frame)
                files, comments = exported()
                if words is CHANGES:
                    self.assertNotEqual(files, before)
                else:
                    self.assertIn(words, "\n".join(comments))

    def test_a_bake_is_no_note(self):
        frame = Frame()
        rigid_body(frame)
        frame.scene.frame_end = 12
        cache = frame.scene.rigidbody_world.point_cache
        cache.frame_end = 12
        with bpy.context.temp_override(scene=frame.scene, point_cache=cache):
            bpy.ops.ptcache.bake(bake=True)
        text = blend.export_text()
        self.assertNotIn("baked", text)
        self.assertGreater(text.count("addKframe"), 1)

    def test_particles_that_rest_need_no_bake(self):
        frame = Frame()
        particles("OBJECT")(frame)
        self.assertIn("its particle system is not baked", blend.export_text())
        frame.cube.particle_systems[0].settings.physics_type = "NO"
        self.assertNotIn("baked", blend.export_text())

    def test_what_has_nothing_of_its_own_kind_is_not_listed(self):
        """Objects that are no meshes, of which geometry nodes make one, or which are empty."""
        for kind in ("hair_curves", "pointclouds", "volumes"):
            for nodes in (("GeometryNodeMeshCube",), ()):
                frame = Frame()
                data = getattr(bpy.data, kind).new("Thing")
                thing = bpy.data.objects.new("Thing", data)
                frame.scene.collection.objects.link(thing)
                if nodes:
                    geometry_nodes(thing, *nodes)
                text = blend.export_text()
                self.assertNotIn("not carried", text)
                self.assertEqual(text.count("\nmesh "), 1 + len(nodes))

    def test_surfaces_of_curves_and_texts_come_once(self):
        for add in ("curve", "text", "metaball", "surface"):
            frame = Frame()
            FEATURES[add][0](frame)
            scene = scene_reader.read(blend.export_text())
            self.assertEqual(len(scene.all("mesh")), 2, add)

    def test_a_mix_with_nothing_is_something(self):
        for order in (("ShaderNodeBsdfTransparent", None), (None, "ShaderNodeBsdfTransparent")):
            frame = Frame()
            frame.shader.inputs["Base Color"].default_value = (0.25, 0.5, 0.75, 1.0)
            mixed(*order, "ShaderNodeFresnel")(frame)
            info = scene_reader.read(blend.export_text()).one("phong_info", "Paint")
            np.testing.assert_allclose(info.vector("diffuse"), (0.25, 0.5, 0.75))
            self.assertNotIn("refraction", info.values)


class NumbersTest(unittest.TestCase):
    """A number that is not finite is an error that names its owner."""

    def check(self, words, frame_of=Frame, **changes):
        for path, value in changes.items():
            frame = Frame()
            sets(path.replace("__", "."), value)(frame)
            with self.assertRaisesRegex(RuntimeError, words):
                blend.export()

    def test_places(self):
        for value in (float("nan"), float("inf")):
            self.check('object "Cube": its place', cube__location=(value, 0.0, 0.0))
            self.check('light "Lamp": its place', lamp__location=(value, 0.0, 0.0))
            self.check('camera "Camera"', scene__camera__location=(0.0, value, 0.0))

    def test_place_at_some_time(self):
        frame = Frame()
        frame.cube.driver_add("location", 0).driver.expression = "1e39 if frame > 9 else 0"
        with self.assertRaisesRegex(RuntimeError, 'object "Cube": its place'):
            blend.export()

    def test_vertices(self):
        frame = Frame()
        frame.cube.data.vertices[3].co.x = float("nan")
        with self.assertRaisesRegex(RuntimeError, 'object "Cube": a number of its vertices'):
            blend.export()

    def test_cameras(self):
        self.check('camera "Camera" is scaled to nothing', scene__camera__scale=(0.0, 0.0, 0.0))
        frame = Frame()
        frame.camera.dof.use_dof, frame.camera.dof.aperture_fstop = True, 0.0
        self.assertNotRegex(blend.export_text(), r"\b(inf|nan)\b")

    def test_colours(self):
        frame = Frame()
        frame.shader.inputs["Emission Strength"].default_value = 3e38
        frame.shader.inputs["Emission Color"].default_value = (1e30, 1.0, 1.0, 1.0)
        frame.background.default_value = (float("nan"), 0.0, 0.0, 1.0)
        with self.assertRaisesRegex(RuntimeError, 'world "World": its colour'):
            blend.export()

    def test_energy(self):
        self.check("light_point Lamp: inf", lamp__data__energy=float("inf"))
