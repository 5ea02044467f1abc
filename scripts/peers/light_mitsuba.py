"""Mitsuba's own path tracer with LLVM on the scenes of physical light.

Materials that Mitsuba has just so: matte, metal (`principled`), glass. Plastic and coat are its nearest relatives, for
the time that they take. A sun with a disc is a distant disc. Mitsuba has no motion blur, so pictures of moving objects
are means of pictures of objects at rest.
"""

import json
import os
import sys

import numpy as np

import job
import light_scenes

if __name__ == "__main__" and json.loads(sys.argv[1]).get("llvm"):
    os.environ["DRJIT_LIBLLVM_PATH"] = json.loads(sys.argv[1])["llvm"]
try:
    import drjit as dr
    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")
except ImportError as error:
    job.missing(error)

FAR = 20_000.0  # the distance of a sun


def rgb(color):
    return {"type": "rgb", "value": [float(c) for c in color]}


def matrix(rows):
    return mi.ScalarTransform4f(np.float64(rows).tolist())


def diffuse(color):
    return {"type": "diffuse", "reflectance": rgb(color)}


def look(material):
    match material:
        case light_scenes.Matte():
            return {"type": "twosided", "bsdf": diffuse(material.color)}
        case light_scenes.Metal():
            return {"type": "twosided", "bsdf": {"type": "principled", "base_color": rgb(material.color),
                                                 "metallic": 1.0, "roughness": material.roughness}}
        case light_scenes.Glass(roughness=0):
            return {"type": "dielectric", "int_ior": material.ior, "ext_ior": 1.0}
        case light_scenes.Glass():
            return {"type": "roughdielectric", "distribution": "ggx", "alpha": material.roughness**2,
                    "int_ior": material.ior, "ext_ior": 1.0}
        case light_scenes.Plastic():
            return {"type": "twosided", "bsdf": {"type": "roughplastic", "distribution": "ggx",
                                                 "alpha": material.roughness**2, "int_ior": 1.5, "ext_ior": 1.0,
                                                 "diffuse_reflectance": rgb(material.color)}}
        case light_scenes.Coat():
            return {"type": "twosided", "bsdf": {"type": "principled", "base_color": rgb(material.color),
                                                 "metallic": 1.0, "roughness": material.roughness, "clearcoat": 1.0,
                                                 "clearcoat_gloss": 1 - material.coat_roughness}}
        case light_scenes.Glow():
            return diffuse((0, 0, 0))
    raise TypeError(material)


def area(radiance):
    return {"type": "area", "radiance": rgb(radiance)}


def rectangle(shape):
    center, a, b = shape.frame()
    normal = np.cross(a, b)
    frame = np.eye(4)
    frame[:3] = np.column_stack([a, b, normal / np.linalg.norm(normal), center])
    return {"type": "rectangle", "to_world": matrix(frame)}


def place(parameters, prefix, shape, pose):
    parameters[prefix + "vertex_positions"] = np.float32(shape.vertices @ pose[:3, :3].T + pose[:3, 3]).ravel()
    if shape.normals is not None:
        parameters[prefix + "vertex_normals"] = np.float32(shape.normals @ pose[:3, :3].T).ravel()
    parameters.update()


def mesh(thing):
    shape, properties = thing.shape, mi.Properties()
    properties["look"] = mi.load_dict(look(thing.material))
    if isinstance(thing.material, light_scenes.Glow):
        properties["emitter"] = mi.load_dict(area(thing.material.radiance))
    made = mi.Mesh(thing.name, len(shape.vertices), len(shape.faces), has_vertex_normals=shape.normals is not None,
                   props=properties)
    parameters = mi.traverse(made)
    parameters["faces"] = shape.faces.astype(np.uint32).ravel()
    place(parameters, "", shape, thing.pose(0))
    return made


def object_of(thing):
    if isinstance(thing.shape, light_scenes.Mesh):
        return mesh(thing)
    if isinstance(thing.shape, light_scenes.Sphere):
        made = {"type": "sphere", "center": list(thing.shape.center), "radius": thing.shape.radius}
    else:
        made = rectangle(thing.shape)
    return made | {"look": look(thing.material)}


def lamp_of(lamp):
    black = {"look": diffuse((0, 0, 0))}
    match lamp:
        case light_scenes.RectangleLamp():
            return rectangle(lamp.shape) | black | {"emitter": area(lamp.radiance)}
        case light_scenes.SphereLamp():
            return {"type": "sphere", "center": [float(c) for c in lamp.center], "radius": float(lamp.radius),
                    "emitter": area(lamp.radiance)} | black
        case light_scenes.Sun():
            way = np.float64(lamp.direction) / np.linalg.norm(lamp.direction)
            size = FAR * np.tan(np.radians(lamp.angle_deg) / 2)
            turn = mi.ScalarTransform4f().look_at(origin=(-FAR * way).tolist(), target=[0, 0, 0], up=[0, 0.1, 1])
            return {"type": "disk", "to_world": turn @ mi.ScalarTransform4f().scale([size, size, 1]),
                    "emitter": area(lamp.radiance())} | black
    raise TypeError(lamp)


def sky_of(sky):
    # The middle of the map is +z and its top +y to Mitsuba, +x and +z to the scenes.
    turn = matrix([[0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    return {"type": "envmap", "bitmap": mi.Bitmap(sky.at_poles()), "to_world": turn}


def camera(scene, sampler):
    sensor = {
        "type": "thinlens" if scene.lens else "perspective", "fov_axis": "y",
        "fov": float(2 * np.degrees(np.arctan(scene.fov))), "near_clip": 1e-3,
        "to_world": mi.ScalarTransform4f().look_at(origin=scene.eye, target=scene.target, up=[0, 0, 1]),
        "film": {"type": "hdrfilm", "width": light_scenes.WIDTH, "height": light_scenes.HEIGHT, "pixel_format": "rgb",
                 "component_format": "float32", "rfilter": {"type": "box"}},
        "sampler": {"type": sampler},
    }
    if scene.lens:
        sensor.update(aperture_radius=scene.lens, focus_distance=scene.focus)
    return sensor


def scene_of(scene, sampler, segments=None):
    depth = segments or scene.segments()
    made = {"type": "scene", "integrator": {"type": "path", "max_depth": depth}, "sensor": camera(scene, sampler)}
    made.update({thing.name: object_of(thing) for thing in scene.things})
    made.update({f"lamp_{number}": lamp_of(lamp) for number, lamp in enumerate(scene.lamps)})
    if scene.sky:
        made["sky"] = sky_of(scene.sky)
    return mi.load_dict(made)


class Mitsuba:
    version = f"{mi.__version__}, {mi.variant()}"

    def __init__(self, scene, order):
        self.scene = scene
        self.slices = order.get("slices", light_scenes.SHUTTER_SLICES)
        self.made = scene_of(scene, order.get("sampler", "multijitter"), order.get("segments"))
        self.moving = [thing for thing in scene.things if thing.moves()]
        self.parameters = mi.traverse(self.made) if self.moving else None
        self.warm = set()

    def picture(self, samples, seed):
        if not self.moving:
            return mi.render(self.made, spp=samples, seed=seed)
        count, total = min(samples, self.slices), 0
        for number, shift in enumerate(np.random.default_rng(seed).random(count)):
            for thing in self.moving:
                place(self.parameters, f"{thing.name}.", thing.shape, thing.pose((number + shift) / count))
            total = total + mi.render(self.made, spp=samples // count, seed=seed * self.slices + number)
            dr.eval(total)
        return total / count

    def render(self, samples, seed, threads):
        dr.set_thread_count(threads)
        if samples not in self.warm:
            # Compiles the kernel for this number of samples.
            self.picture(samples, seed).numpy()
            self.warm.add(samples)
        return self.timed(samples, seed)

    def reference(self, samples, seed, threads):
        dr.set_thread_count(threads)
        return self.timed(samples, seed)

    def timed(self, samples, seed):
        began = job.user_time()
        pixels = self.picture(samples, seed).numpy()
        return pixels, job.user_time() - began


if __name__ == "__main__":
    job.serve(Mitsuba, light_scenes.scene)
