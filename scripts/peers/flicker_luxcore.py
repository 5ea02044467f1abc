"""LuxCore, by pyluxcore, on the frames of flicker.py: its path tracer, alone or with the caches of PhotonGI."""

import time

import numpy as np

import flicker_job
import job
import light_scenes

try:
    import pyluxcore
except ImportError as error:
    job.missing(error)

from render_luxcore import columns, define, floats, properties

SQUARE = ((0, 1, 2), (0, 2, 3))


def ball(shape, across=256):
    v, u = np.meshgrid(np.linspace(0, np.pi, across // 2 + 1), np.linspace(0, 2 * np.pi, across + 1), indexing="ij")
    normals = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1).reshape(-1, 3)
    row = across + 1
    corners = [
        (r * row + c, (r + 1) * row + c, (r + 1) * row + c + 1, r * row + c + 1)
        for r in range(across // 2)
        for c in range(across)
    ]
    return normals * shape.radius + shape.center, [t for a, b, c, d in corners for t in ((a, b, c), (a, c, d))], normals


def material(thing):
    name, what = f"scene.materials.{thing.name}", thing.material
    match what:
        case light_scenes.Matte():
            return {f"{name}.type": "matte", f"{name}.kd": floats(what.color)}
        case light_scenes.Glass():
            return {
                f"{name}.type": "glass",
                f"{name}.kr": [1.0] * 3,
                f"{name}.kt": [1.0] * 3,
                f"{name}.interiorior": what.ior,
            }
    raise TypeError(what)


def build(frame):
    scene, ratio = pyluxcore.Scene(), light_scenes.WIDTH / light_scenes.HEIGHT
    scene.Parse(
        properties(
            {
                "scene.camera.type": "perspective",
                "scene.camera.lookat.orig": floats(frame.eye),
                "scene.camera.lookat.target": floats(frame.target),
                "scene.camera.up": [0.0, 0.0, 1.0],
                "scene.camera.fieldofview": np.degrees(2 * np.arctan(frame.fov)),  # of the shorter side
                "scene.camera.screenwindow": [-ratio, ratio, -1.0, 1.0],
                "scene.camera.autofocus.enable": False,
            }
        )
    )
    for thing in frame.things:
        match thing.shape:
            case light_scenes.Mesh(vertices, faces, normals):
                define(scene, thing.name, vertices, faces, normals)
            case light_scenes.Sphere():
                define(scene, thing.name, *ball(thing.shape))
            case light_scenes.Rectangle():
                define(scene, thing.name, thing.shape.corners(), SQUARE)
        scene.Parse(properties(material(thing)))
        scene.Parse(
            properties(
                {
                    f"scene.objects.{thing.name}.shape": thing.name,
                    f"scene.objects.{thing.name}.material": thing.name,
                    f"scene.objects.{thing.name}.transformation": columns(thing.pose(0)),
                }
            )
        )
    for number, lamp in enumerate(frame.lamps):
        name = f"lamp_{number}"
        define(scene, name, lamp.shape.corners(), SQUARE)
        scene.Parse(
            properties(
                {
                    f"scene.materials.{name}.type": "matte",
                    f"scene.materials.{name}.kd": [0.0] * 3,
                    f"scene.materials.{name}.emission": floats(lamp.radiance),
                    f"scene.objects.{name}.shape": name,
                    f"scene.objects.{name}.material": name,
                }
            )
        )
    return scene


def settings(frame, how, seed, threads):
    values = {
        "renderengine.type": "PATHCPU",
        "renderengine.seed": seed,
        "native.threads.count": threads,
        "sampler.type": "SOBOL",
        "sampler.sobol.adaptive.strength": 0.0,
        "path.pathdepth.total": frame.bounces + 1,
        "path.pathdepth.diffuse": frame.bounces + 1,
        "path.pathdepth.glossy": frame.bounces + 1,
        "path.pathdepth.specular": frame.bounces + 1,
        "path.clamping.variance.maxvalue": 0.0,
        "film.width": light_scenes.WIDTH,
        "film.height": light_scenes.HEIGHT,
        "film.filter.type": "NONE",
        "film.noiseestimation.warmup": 100000,
        "film.imagepipelines.0.0.type": "NOP",
        "film.outputs.0.type": "RGB",
        "film.outputs.0.filename": "never_written.exr",
    }
    if how == "photongi":
        values.update(
            {
                "path.photongi.sampler.type": "METROPOLIS",
                "path.photongi.photon.maxcount": 200000,
                "path.photongi.photon.maxdepth": frame.bounces + 1,
                "path.photongi.indirect.enabled": True,
                "path.photongi.indirect.maxsize": 20000,
                "path.photongi.indirect.lookup.radius": 0.15,
                "path.photongi.caustic.enabled": True,
                "path.photongi.caustic.maxsize": 50000,
                "path.photongi.caustic.lookup.radius": 0.04,
            }
        )
    return properties(values)


class LuxCore:
    version = pyluxcore.Version()

    def __init__(self, order):
        self.how = order["how"]

    def render(self, frame, seed, seconds, threads, number):
        """Renders until so much processor time has passed, that of the caches included."""
        session = pyluxcore.RenderSession(
            pyluxcore.RenderConfig(settings(frame, self.how, seed, threads), build(frame))
        )
        began = job.user_time()
        session.Start()
        while True:
            time.sleep(0.01)
            session.UpdateStats()
            passed = session.GetStats().Get("stats.renderengine.pass").GetInt()
            if job.user_time() - began >= seconds and passed >= 1:
                break
        session.Stop()
        spent = job.user_time() - began
        pixels = np.zeros(light_scenes.WIDTH * light_scenes.HEIGHT * 3, dtype=np.float32)
        session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, pixels)
        return pixels.reshape(light_scenes.HEIGHT, light_scenes.WIDTH, 3)[::-1], spent


if __name__ == "__main__":
    pyluxcore.Init()
    flicker_job.serve(LuxCore)
