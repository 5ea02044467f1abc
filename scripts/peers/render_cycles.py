"""Cycles, Blender's renderer, from PyPI's bpy: scene and BVH are kept from one picture to the next."""

import tempfile
from pathlib import Path

import numpy as np

import job
import stills

try:
    import bpy
    from mathutils import Matrix
except ImportError as error:
    job.missing(error)

POSES = 16  # key frames of moving objects; Cycles interpolates between them


def look(name, color):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (*color, 1)
    links.new(diffuse.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def mirror_look(name):
    """Mixes half of a matte floor and half of a mirror, each twice as bright."""
    material = look(name, [2 * c for c in stills.FLOOR_UNDER_MIRROR])
    nodes, links = material.node_tree.nodes, material.node_tree.links
    diffuse, output = nodes["Diffuse BSDF"], nodes["Material Output"]
    mirror = nodes.new("ShaderNodeBsdfAnisotropic")
    mirror.distribution = "GGX"
    mirror.inputs["Color"].default_value = (*[2 * stills.MIRROR] * 3, 1)
    mirror.inputs["Roughness"].default_value = stills.MIRROR_ALPHA**0.5
    mix = nodes.new("ShaderNodeMixShader")
    links.new(diffuse.outputs[0], mix.inputs[1])
    links.new(mirror.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], output.inputs["Surface"])
    return material


def glass_look(name):
    material = look(name, (1, 1, 1))
    nodes, links = material.node_tree.nodes, material.node_tree.links
    glass = nodes.new("ShaderNodeBsdfGlass")
    glass.distribution = "GGX"
    glass.inputs["Roughness"].default_value = stills.GLASS_ALPHA**0.5
    glass.inputs["IOR"].default_value = stills.GLASS_INDEX
    links.new(glass.outputs[0], nodes["Material Output"].inputs["Surface"])
    return material


def add(name, data):
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def add_mesh(name, vertices, faces, material):
    data = bpy.data.meshes.new(name)
    data.from_pydata([tuple(v) for v in vertices], [], [tuple(map(int, f)) for f in faces])
    data.polygons.foreach_set("use_smooth", [True] * len(data.polygons))
    data.materials.append(material)
    return add(name, data)


def add_ball(material):
    """Cycles has no spheres: 128 x 64 quads with smooth normals."""
    center, radius, _ = stills.BALL
    v, u = np.meshgrid(np.linspace(0, np.pi, 65), np.linspace(0, 2 * np.pi, 129), indexing="ij")
    points = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1)
    quads = [(r * 129 + c, (r + 1) * 129 + c, (r + 1) * 129 + c + 1, r * 129 + c + 1)
             for r in range(64) for c in range(128)]
    ball = add_mesh("ball", (points * radius + center).reshape(-1, 3), quads, material)
    normals = points.reshape(-1, 3)
    ball.data.normals_split_custom_set_from_vertices([tuple(n) for n in normals])


def add_moving(still, thing):
    thing.rotation_mode = "QUATERNION"
    for step in range(POSES + 1):
        thing.matrix_world = Matrix(still.pose(thing.name, step / POSES).tolist())
        for channel in ("location", "rotation_quaternion"):
            # The shutter is open for the first half of the frame.
            thing.keyframe_insert(channel, frame=1 + stills.SHUTTER * step / POSES)
    action = thing.animation_data.action
    curves = action.fcurves if hasattr(action, "fcurves") else action.layers[0].strips[0].channelbags[0].fcurves
    for curve in curves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    thing.cycles.use_motion_blur = True
    thing.cycles.motion_steps = 4


def add_lamp():
    center, a, b = stills.light_frame()
    data = bpy.data.lights.new("lamp", "AREA")
    data.shape = "RECTANGLE"
    data.size, data.size_y = 2 * np.linalg.norm(a), 2 * np.linalg.norm(b)
    # A lamp of P watts has a radiance of P / (pi x area).
    data.energy = stills.RADIANCE * np.pi * data.size * data.size_y
    data.color = stills.LIGHT_COLOR
    data.cycles.use_multiple_importance_sampling = False
    frame = np.eye(4)
    normal = np.cross(a, b) / np.linalg.norm(np.cross(a, b))
    normal = normal if normal[2] > 0 else -normal  # Lamps shine along -z.
    x = a / np.linalg.norm(a)
    frame[:3] = np.column_stack([x, np.cross(normal, x), normal, center])
    lamp = add("lamp", data)
    lamp.matrix_world = Matrix(frame.tolist())
    lamp.visible_camera = lamp.visible_glossy = lamp.visible_transmission = False


def add_mirrored_lamp():
    """Adds the lamp that mirrors and glass see instead: a rectangle that is no brighter than in slo-rt."""
    center, a, b = stills.light_frame()
    corners = [center + i * a + j * b + (0, 0, 0.01) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    material = look("shining", stills.LIGHT_COLOR)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    emission = nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (*stills.LIGHT_COLOR, 1)
    links.new(emission.outputs[0], nodes["Material Output"].inputs["Surface"])
    material.cycles.emission_sampling = "NONE"
    lamp = add_mesh("mirrored lamp", corners, [(0, 1, 2, 3)], material)
    lamp.visible_camera = lamp.visible_diffuse = lamp.visible_shadow = False


def add_camera(still):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.angle_y = 2 * np.arctan(stills.FOV)
    right, up, forward = stills.camera_frame()
    frame = np.eye(4)
    frame[:3] = np.column_stack([right, up, -forward, stills.EYE])
    if still.lens:
        data.dof.use_dof = True
        data.dof.focus_distance = stills.FOCUS
        # The f-number is the focal length, here in millimetres, over the diameter of the lens.
        data.dof.aperture_fstop = data.lens / 1000 / (2 * still.lens)
    camera = add("camera", data)
    camera.matrix_world = Matrix(frame.tolist())
    bpy.context.scene.camera = camera


def build(still):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for name, (_, color) in stills.MESHES.items():
        glass = still.rough and name == stills.GLASS
        vertices, faces, _ = stills.mesh(name)
        thing = add_mesh(name, vertices, faces, glass_look(name) if glass else look(name, color))
        thing.matrix_world = Matrix(still.pose(name).tolist())
        if still.moves and name == stills.MOVES:
            add_moving(still, thing)
    floor = [(x, y, 0) for x, y in ((-500, -500), (500, -500), (500, 500), (-500, 500))]
    add_mesh("floor", floor, [(0, 1, 2, 3)], mirror_look("floor") if still.rough else look("floor", stills.FLOOR))
    add_ball(look("ball", stills.BALL[2]))
    add_lamp()
    if still.rough:
        add_mirrored_lamp()
    add_camera(still)
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (*stills.SKY, 1)
    world.cycles_visibility.diffuse = False
    world.cycles.sampling_method = "NONE"
    bpy.context.scene.world = world


def settings(still, order):
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = stills.WIDTH, stills.HEIGHT, 100
    render.threads_mode = "FIXED"
    render.use_persistent_data = True
    render.use_motion_blur = still.moves
    render.motion_blur_shutter = stills.SHUTTER
    render.motion_blur_position = "START"
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode = "RGB"
    render.image_settings.color_depth = "32"
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.sampling_pattern = order.get("pattern", "TABULATED_SOBOL")
    cycles.direct_light_sampling_type = "NEXT_EVENT_ESTIMATION"
    cycles.use_light_tree = False
    cycles.use_auto_tile = False
    cycles.light_sampling_threshold = 0
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    bounces = stills.BOUNCES if still.rough else 0
    cycles.max_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces
    cycles.diffuse_bounces = cycles.volume_bounces = cycles.transparent_max_bounces = 0


class Cycles:
    version = bpy.app.version_string

    def __init__(self, still, order):
        build(still)
        settings(still, order)
        self.folder = tempfile.TemporaryDirectory()
        self.threads = None

    def render(self, samples, seed, threads):
        scene = bpy.context.scene
        scene.cycles.samples, scene.cycles.seed = samples, seed
        path = Path(self.folder.name) / "still.exr"
        scene.render.filepath = str(path)
        if threads != self.threads:
            # Hands the scene over and builds the BVH.
            scene.render.threads, self.threads = threads, threads
            scene.cycles.samples = 1
            bpy.ops.render.render(write_still=True)
            scene.cycles.samples = samples
            scene.update_tag()
            bpy.context.view_layer.update()
        began = job.user_time()
        bpy.ops.render.render(write_still=True)
        seconds = job.user_time() - began
        image = bpy.data.images.load(str(path))
        image.colorspace_settings.name = "Non-Color"
        pixels = np.array(image.pixels[:], dtype=np.float32).reshape(stills.HEIGHT, stills.WIDTH, -1)
        bpy.data.images.remove(image)
        return pixels[::-1], seconds


if __name__ == "__main__":
    job.serve(Cycles)
