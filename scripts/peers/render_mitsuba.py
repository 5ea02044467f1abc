"""Mitsuba 3 with LLVM: all rays of a picture together, 16 at a time on AVX-512.

Without --llvm, Dr.Jit searches for a libLLVM.so itself. With AVX-512 it must be version 17 or later: 15 and 16
fail with "Cannot select: f32 = fminimum". Mitsuba has no motion blur, so pictures of moving objects are means of
pictures of objects at rest.
"""

import json
import os
import sys

import numpy as np

import job
import stills

SLICES = 8  # most poses of moving objects; 16 take longer without reducing the error

if __name__ == "__main__" and json.loads(sys.argv[1]).get("llvm"):
    os.environ["DRJIT_LIBLLVM_PATH"] = json.loads(sys.argv[1])["llvm"]
try:
    import drjit as dr
    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")
except ImportError as error:
    job.missing(error)


class Direct(mi.SamplingIntegrator):
    """Integrates direct light on diffuse surfaces, and reflection and refraction, but no diffuse interreflection."""

    def __init__(self, props):
        super().__init__(props)
        self.bounces = props.get("bounces", 0)
        self.matte = mi.BSDFContext()
        self.matte.type_mask = mi.BSDFFlags.DiffuseReflection
        self.mirror = mi.BSDFContext()
        self.mirror.component = 0

    def sample(self, scene, sampler, ray, medium=None, active=True):
        light = self.traced(scene, sampler, ray) if self.bounces else self.first_hit(scene, sampler, ray)
        return light, mi.Bool(True), []

    def direct(self, scene, sampler, si, bsdf, active):
        ds, light = scene.sample_emitter_direction(si, sampler.next_2d(active), True, active)
        return dr.select(active & (ds.pdf > 0), light * bsdf.eval(self.matte, si, si.to_local(ds.d), active), 0)

    def first_hit(self, scene, sampler, ray):
        si = scene.ray_intersect(ray)
        return self.direct(scene, sampler, si, si.bsdf(ray), si.is_valid())

    @dr.syntax
    def traced(self, scene, sampler, ray):
        lobes, mirror = mi.BSDFContext(), self.mirror
        ray = mi.Ray3f(ray)
        light, weight, depth, active = mi.Color3f(0), mi.Color3f(1), mi.UInt32(0), mi.Bool(True)
        while active:
            si = scene.ray_intersect(ray, active)
            light += dr.select(active & ~si.is_valid(), weight * mi.Color3f(*stills.SKY), 0)
            active &= si.is_valid()
            lamp = active & si.shape.is_emitter()
            light += dr.select(lamp, weight * mi.Color3f(*stills.LIGHT_COLOR), 0)
            bsdf = si.bsdf(ray)
            light += weight * self.direct(scene, sampler, si, bsdf, active & ~lamp)
            glass = active & mi.has_flag(bsdf.flags(), mi.BSDFFlags.GlossyTransmission)
            floor = active & ~glass & mi.has_flag(bsdf.flags(), mi.BSDFFlags.GlossyReflection)
            active &= (glass | floor) & (depth < self.bounces)
            choice, place = sampler.next_1d(active), sampler.next_2d(active)
            through, through_value = bsdf.sample(lobes, si, choice, place, active & glass)
            mirrored, mirrored_value = bsdf.sample(mirror, si, choice, place, active & floor)
            weight *= dr.select(glass, through_value, mirrored_value)
            ray = si.spawn_ray(si.to_world(dr.select(glass, through.wo, mirrored.wo)))
            depth += 1
            active &= dr.max(weight) > 0
        return light


mi.register_integrator("still_direct", Direct)


def diffuse(color):
    return {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(color)}}


def two_sided(bsdf):
    return {"type": "twosided", "bsdf": bsdf}


def floor_look(still):
    if not still.rough:
        return diffuse(stills.FLOOR)
    mirror = {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": stills.MIRROR_ALPHA,
              "specular_reflectance": {"type": "rgb", "value": 2 * stills.MIRROR}}
    return {"type": "blendbsdf", "weight": 0.5, "mirror": mirror,
            "matte": diffuse(2 * c for c in stills.FLOOR_UNDER_MIRROR)}


def mesh(still, name):
    vertices, faces, normals = stills.mesh(name)
    look = two_sided(diffuse(stills.MESHES[name][1]))
    if still.rough and name == stills.GLASS:
        look = {"type": "roughdielectric", "distribution": "ggx", "alpha": stills.GLASS_ALPHA,
                "int_ior": stills.GLASS_INDEX, "ext_ior": 1.0}
    properties = mi.Properties()
    properties["look"] = mi.load_dict(look)
    shape = mi.Mesh(name, len(vertices), len(faces), has_vertex_normals=True, props=properties)
    parameters = mi.traverse(shape)
    parameters["faces"] = faces.astype(np.uint32).ravel()
    place(parameters, "", vertices, normals, still.pose(name))
    return shape


def place(parameters, prefix, vertices, normals, pose):
    parameters[prefix + "vertex_positions"] = np.float32(vertices @ pose[:3, :3].T + pose[:3, 3]).ravel()
    parameters[prefix + "vertex_normals"] = np.float32(normals @ pose[:3, :3].T).ravel()
    parameters.update()


def camera(still, sampler):
    sensor = {
        "type": "thinlens" if still.lens else "perspective", "fov_axis": "y",
        "fov": float(2 * np.degrees(np.arctan(stills.FOV))),
        "to_world": mi.ScalarTransform4f().look_at(origin=stills.EYE, target=stills.TARGET, up=[0, 0, 1]),
        "film": {"type": "hdrfilm", "width": stills.WIDTH, "height": stills.HEIGHT, "pixel_format": "rgb",
                 "component_format": "float32", "rfilter": {"type": "box"}},
        "sampler": {"type": sampler},
    }
    if still.lens:
        sensor.update(aperture_radius=still.lens, focus_distance=stills.FOCUS)
    return sensor


def integrator(still, name):
    bounces = stills.BOUNCES if still.rough else 0
    if name == "direct":
        return {"type": "still_direct", "bounces": bounces}
    # For its own integrator: light from a lamp on a diffuse surface counts as one more segment.
    return {"type": name, "max_depth": bounces + 2, "rr_depth": bounces + 2}


def scene_of(still, sampler, transport):
    center, a, b = stills.light_frame()
    matrix = np.eye(4)
    matrix[:3] = np.column_stack([a, -b, np.cross(a, -b) / np.linalg.norm(np.cross(a, b)), center])
    radiance = [stills.RADIANCE * c for c in stills.LIGHT_COLOR]
    ball, radius, color = stills.BALL
    scene = {
        "type": "scene",
        "integrator": integrator(still, transport),
        "sensor": camera(still, sampler),
        "lamp": {"type": "rectangle", "to_world": mi.ScalarTransform4f(matrix),
                 "emitter": {"type": "area", "radiance": {"type": "rgb", "value": radiance}}},
        "floor": {"type": "rectangle", "to_world": mi.ScalarTransform4f().scale([500, 500, 1]),
                  "look": floor_look(still)},
        "ball": {"type": "sphere", "center": ball, "radius": radius, "look": two_sided(diffuse(color))},
    }
    scene.update({name: mesh(still, name) for name in stills.MESHES})
    return mi.load_dict(scene)


class Mitsuba:
    version = f"{mi.__version__}, {mi.variant()}"

    def __init__(self, still, order):
        self.still = still
        self.slices = order.get("slices", SLICES)
        self.scene = scene_of(still, order.get("sampler", "multijitter"), order.get("integrator", "direct"))
        self.parameters = mi.traverse(self.scene)
        self.moving = stills.mesh(stills.MOVES)
        self.warm = set()

    def picture(self, samples, seed):
        if not self.still.moves:
            return mi.render(self.scene, spp=samples, seed=seed)
        count = min(samples, self.slices)
        total = 0
        for number, shift in enumerate(np.random.default_rng(seed).random(count)):
            pose = self.still.pose(stills.MOVES, (number + shift) / count)
            place(self.parameters, f"{stills.MOVES}.", self.moving[0], self.moving[2], pose)
            total = total + mi.render(self.scene, spp=samples // count, seed=seed * self.slices + number)
            dr.eval(total)
        return total / count

    def render(self, samples, seed, threads):
        dr.set_thread_count(threads)
        if samples not in self.warm:
            # Compiles the kernel for this number of samples.
            self.picture(samples, seed).numpy()
            self.warm.add(samples)
        began = job.user_time()
        pixels = self.picture(samples, seed).numpy()
        return pixels, job.user_time() - began


if __name__ == "__main__":
    job.serve(Mitsuba)
