"""Cycles, from PyPI's bpy, on the scenes of physical light; without clamps, blurs and thresholds.

Spheres are 256 x 128 quads with the normals of the sphere. Materials are Blender's Principled BSDF.
"""

import tempfile
from pathlib import Path

import numpy as np

import job
import light_scenes

try:
    import bpy
    from mathutils import Matrix
except ImportError as error:
    job.missing(error)

POSES = 16  # key frames of moving objects; Cycles interpolates between them


def new_material(name):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.node_tree.nodes.clear()
    output = material.node_tree.nodes.new("ShaderNodeOutputMaterial")
    return material, output.inputs["Surface"]


def shader(material, surface, kind, values):
    node = material.node_tree.nodes.new(kind)
    for name, value in values.items():
        node.inputs[name].default_value = value
    material.node_tree.links.new(node.outputs[0], surface)
    return node


def look(thing):
    material, surface = new_material(thing.name)
    what = thing.material
    match what:
        case light_scenes.Matte():
            shader(material, surface, "ShaderNodeBsdfDiffuse", {"Color": (*what.color, 1)})
        case light_scenes.Metal():
            shader(material, surface, "ShaderNodeBsdfPrincipled",
                   {"Base Color": (*what.color, 1), "Metallic": 1, "Roughness": what.roughness})
        case light_scenes.Glass():
            shader(material, surface, "ShaderNodeBsdfPrincipled",
                   {"Base Color": (1, 1, 1, 1), "Transmission Weight": 1, "Roughness": what.roughness, "IOR": what.ior})
        case light_scenes.Plastic():
            shader(material, surface, "ShaderNodeBsdfPrincipled",
                   {"Base Color": (*what.color, 1), "Roughness": what.roughness, "IOR": 1.5})
        case light_scenes.Coat():
            shader(material, surface, "ShaderNodeBsdfPrincipled",
                   {"Base Color": (*what.color, 1), "Metallic": 1, "Roughness": what.roughness, "Coat Weight": 1,
                    "Coat Roughness": what.coat_roughness, "Coat IOR": 1.5})
        case light_scenes.Glow():
            shine(material, surface, what.radiance)
    return material


def shine(material, surface, radiance):
    shader(material, surface, "ShaderNodeEmission", {"Color": (*map(float, radiance), 1), "Strength": 1.0})
    material.cycles.emission_sampling = "FRONT"


def add(name, data):
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def add_faces(name, vertices, faces, material, normals=None):
    data = bpy.data.meshes.new(name)
    data.from_pydata([tuple(map(float, v)) for v in vertices], [], [tuple(map(int, f)) for f in faces])
    data.materials.append(material)
    if normals is not None:
        data.polygons.foreach_set("use_smooth", [True] * len(data.polygons))
        data.normals_split_custom_set_from_vertices([tuple(map(float, n)) for n in normals])
    return add(name, data)


def ball(shape, across=256):
    v, u = np.meshgrid(np.linspace(0, np.pi, across // 2 + 1), np.linspace(0, 2 * np.pi, across + 1), indexing="ij")
    points = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1)
    row = across + 1
    quads = [(r * row + c, (r + 1) * row + c, (r + 1) * row + c + 1, r * row + c + 1)
             for r in range(across // 2) for c in range(across)]
    return (points * shape.radius + shape.center).reshape(-1, 3), quads, points.reshape(-1, 3)


def add_thing(thing):
    material = look(thing)
    match thing.shape:
        case light_scenes.Mesh(vertices, faces, normals):
            made = add_faces(thing.name, vertices, faces, material, normals)
        case light_scenes.Sphere():
            vertices, faces, normals = ball(thing.shape)
            made = add_faces(thing.name, vertices, faces, material, normals)
        case light_scenes.Rectangle():
            made = add_faces(thing.name, thing.shape.corners(), [(0, 1, 2, 3)], material)
    made.matrix_world = Matrix(thing.pose(0).tolist())
    if thing.moves():
        move(thing, made)


def move(thing, made):
    made.rotation_mode = "QUATERNION"
    for step in range(POSES + 1):
        made.matrix_world = Matrix(thing.pose(step / POSES).tolist())
        for channel in ("location", "rotation_quaternion"):
            made.keyframe_insert(channel, frame=1 + step / POSES)
    action = made.animation_data.action
    curves = action.fcurves if hasattr(action, "fcurves") else action.layers[0].strips[0].channelbags[0].fcurves
    for curve in curves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
    made.cycles.use_motion_blur = True
    made.cycles.motion_steps = 4


def add_lamp(number, lamp):
    name = f"lamp_{number}"
    match lamp:
        case light_scenes.RectangleLamp():
            center, a, b = lamp.shape.frame()
            data = bpy.data.lights.new(name, "AREA")
            data.shape, data.size, data.size_y = "RECTANGLE", 2 * np.linalg.norm(a), 2 * np.linalg.norm(b)
            data.color, data.energy = lamp.radiance, np.pi * data.size * data.size_y
            # Lamps shine along -z.
            axes = [a / np.linalg.norm(a), -b / np.linalg.norm(b)]
            frame = np.eye(4)
            frame[:3] = np.column_stack([*axes, np.cross(*axes), center])
        case light_scenes.SphereLamp():
            data = bpy.data.lights.new(name, "POINT")
            data.shadow_soft_size, data.use_soft_falloff = lamp.radius, False
            data.color, data.energy = lamp.power(), 1.0
            frame = np.eye(4)
            frame[:3, 3] = lamp.center
        case light_scenes.Sun():
            data = bpy.data.lights.new(name, "SUN")
            data.angle, data.color, data.energy = np.radians(lamp.angle_deg), lamp.irradiance, 1.0
            back = -np.float64(lamp.direction) / np.linalg.norm(lamp.direction)
            side = np.cross((0, 0, 1), back)
            side /= np.linalg.norm(side)
            frame = np.eye(4)
            frame[:3, :3] = np.column_stack([side, np.cross(back, side), back])
    made = add(name, data)
    made.matrix_world = Matrix(frame.tolist())
    made.visible_camera = True


def add_sky(sky):
    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    bpy.context.scene.world = world
    background = world.node_tree.nodes["Background"]
    if sky is None:
        background.inputs["Color"].default_value = (0, 0, 0, 1)
        return
    pixels = sky.centered()[::-1]
    image = bpy.data.images.new("sky", pixels.shape[1], pixels.shape[0], float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(np.concatenate([pixels, np.ones_like(pixels[..., :1])], axis=-1).ravel())
    image.update()
    image.pack()
    texture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    world.node_tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    world.cycles.sampling_method = "MANUAL"
    world.cycles.sample_map_resolution = pixels.shape[1]


def add_camera(scene):
    data = bpy.data.cameras.new("camera")
    data.sensor_fit = "VERTICAL"
    data.angle_y = 2 * np.arctan(scene.fov)
    data.clip_start = 1e-3
    forward = np.subtract(scene.target, scene.eye)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, (0, 0, 1))
    right /= np.linalg.norm(right)
    frame = np.eye(4)
    frame[:3] = np.column_stack([right, np.cross(right, forward), -forward, scene.eye])
    if scene.lens:
        data.dof.use_dof, data.dof.focus_distance = True, scene.focus
        # The f-number is the focal length, here in millimetres, over the diameter of the lens.
        data.dof.aperture_fstop = data.lens / 1000 / (2 * scene.lens)
    camera = add("camera", data)
    camera.matrix_world = Matrix(frame.tolist())
    bpy.context.scene.camera = camera


def build(scene):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for thing in scene.things:
        add_thing(thing)
    for number, lamp in enumerate(scene.lamps):
        add_lamp(number, lamp)
    add_sky(scene.sky)
    add_camera(scene)


def settings(scene, order):
    here = bpy.context.scene
    render, cycles = here.render, here.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = light_scenes.WIDTH, light_scenes.HEIGHT
    render.resolution_percentage = 100
    render.threads_mode = "FIXED"
    render.use_persistent_data = True
    render.use_motion_blur = scene.moves()
    render.motion_blur_shutter, render.motion_blur_position = 1.0, "START"
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode = "RGB"
    render.image_settings.color_depth = "32"
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sampling_pattern = order.get("pattern", "TABULATED_SOBOL")
    cycles.use_light_tree = order.get("light_tree", True)
    cycles.use_auto_tile = False
    cycles.light_sampling_threshold = 0
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = scene.bounces
    cycles.volume_bounces = cycles.transparent_max_bounces = 0


class Cycles:
    version = bpy.app.version_string

    def __init__(self, scene, order):
        build(scene)
        settings(scene, order)
        self.folder = tempfile.TemporaryDirectory()
        self.threads = None

    def render(self, samples, seed, threads):
        scene = bpy.context.scene
        scene.cycles.samples, scene.cycles.seed = samples, seed
        path = Path(self.folder.name) / "picture.exr"
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
        pixels = np.array(image.pixels[:], dtype=np.float32).reshape(light_scenes.HEIGHT, light_scenes.WIDTH, -1)
        bpy.data.images.remove(image)
        return pixels[::-1], seconds


if __name__ == "__main__":
    job.serve(Cycles, light_scenes.scene)
