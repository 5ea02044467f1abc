"""LuxCore by pyluxcore: path tracing on the CPU with its Sobol sampler."""

import time

import numpy as np

import job
import stills

try:
    import pyluxcore
except ImportError as error:
    job.missing(error)

POSES = 16  # of moving objects; LuxCore interpolates between them


def properties(values):
    listed = pyluxcore.Properties()
    for name, value in values.items():
        listed.Set(pyluxcore.Property(name, value if isinstance(value, (list, str, bool, int)) else float(value)))
    return listed


def columns(matrix):
    return [float(v) for v in np.asarray(matrix).T.ravel()]


def floats(values):
    return [float(v) for v in values]


def matte(name, color):
    return {f"scene.materials.{name}.type": "matte", f"scene.materials.{name}.kd": floats(color)}


def materials():
    values = {}
    for name, color in (("white", stills.WHITE), ("blue", stills.BLUE), ("red", stills.RED)):
        values.update(matte(name, color))
    values.update(matte("dark", (0, 0, 0)))
    values["scene.materials.dark.emission"] = floats(stills.RADIANCE * c for c in stills.LIGHT_COLOR)
    values.update(matte("floor", stills.FLOOR))
    return values


def camera(still):
    ratio = stills.WIDTH / stills.HEIGHT
    values = {
        "scene.camera.type": "perspective",
        "scene.camera.lookat.orig": floats(stills.EYE),
        "scene.camera.lookat.target": floats(stills.TARGET),
        "scene.camera.up": [0.0, 0.0, 1.0],
        # For the shorter side.
        "scene.camera.fieldofview": np.degrees(2 * np.arctan(stills.FOV)),
        "scene.camera.screenwindow": [-ratio, ratio, -1.0, 1.0],
        "scene.camera.lensradius": still.lens,
        "scene.camera.autofocus.enable": False,
        "scene.camera.focaldistance": stills.FOCUS,
    }
    if still.moves:
        values.update({"scene.camera.shutteropen": 0.0, "scene.camera.shutterclose": 1.0})
    return values


def define(scene, name, vertices, faces, normals=None):
    scene.DefineMesh(name, [tuple(floats(v)) for v in vertices], [tuple(map(int, f)) for f in faces],
                     None if normals is None else [tuple(floats(n)) for n in normals], None, None, None)


def ball():
    """LuxCore has no spheres: 128 x 64 quads with smooth normals."""
    center, radius, _ = stills.BALL
    v, u = np.meshgrid(np.linspace(0, np.pi, 65), np.linspace(0, 2 * np.pi, 129), indexing="ij")
    normals = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1).reshape(-1, 3)
    corners = [(r * 129 + c, (r + 1) * 129 + c, (r + 1) * 129 + c + 1, r * 129 + c + 1)
               for r in range(64) for c in range(128)]
    return normals * radius + center, [t for a, b, c, d in corners for t in ((a, b, c), (a, c, d))], normals


def add(scene, name, material, matrices):
    values = {f"scene.objects.{name}.shape": name, f"scene.objects.{name}.material": material}
    if len(matrices) == 1:
        values[f"scene.objects.{name}.transformation"] = columns(matrices[0])
    else:
        for step, matrix in enumerate(matrices):
            values[f"scene.objects.{name}.motion.{step}.time"] = step / (len(matrices) - 1)
            values[f"scene.objects.{name}.motion.{step}.transformation"] = columns(matrix)
    scene.Parse(properties(values))


def build(still):
    scene = pyluxcore.Scene()
    scene.Parse(properties(camera(still)))
    scene.Parse(properties(materials()))
    words = {stills.WHITE: "white", stills.BLUE: "blue", stills.RED: "red"}
    for name, (_, color) in stills.MESHES.items():
        define(scene, name, *stills.mesh(name))
        moves = still.moves and name == stills.MOVES
        matrices = [still.pose(name, step / POSES) for step in range(POSES + 1 if moves else 1)]
        add(scene, name, words[color], matrices)
    define(scene, "ball", *ball())
    add(scene, "ball", "red", [np.eye(4)])
    square = ((0, 1, 2), (0, 2, 3))
    define(scene, "floor", ((-500, -500, 0), (500, -500, 0), (500, 500, 0), (-500, 500, 0)), square)
    add(scene, "floor", "floor", [np.eye(4)])
    center, a, b = stills.light_frame()
    corners = [center + i * a + j * b for i, j in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
    if np.cross(corners[1] - corners[0], corners[2] - corners[0])[2] > 0:
        corners.reverse()
    define(scene, "lamp", corners, square)
    add(scene, "lamp", "dark", [np.eye(4)])
    return scene


def settings(order, samples, seed, threads):
    return properties({
        "renderengine.type": "PATHCPU",
        "renderengine.seed": seed + 1,
        "native.threads.count": threads,
        "sampler.type": order.get("sampler", "SOBOL"),
        "sampler.sobol.adaptive.strength": 0.0,
        "sampler.random.adaptive.strength": 0.0,
        "path.pathdepth.total": 1,
        "path.pathdepth.diffuse": 1,
        "path.pathdepth.glossy": 1,
        "path.pathdepth.specular": 1,
        "path.clamping.variance.maxvalue": 0.0,
        "lightstrategy.type": "UNIFORM",
        "film.width": stills.WIDTH,
        "film.height": stills.HEIGHT,
        "film.filter.type": "NONE",
        "film.noiseestimation.warmup": 100000,
        "film.imagepipelines.0.0.type": "NOP",
        "film.outputs.0.type": "RGB",
        "film.outputs.0.filename": "never_written.exr",
        "batch.haltspp": samples,
    })


class LuxCore:
    version = pyluxcore.Version()

    def __init__(self, still, order):
        if still.rough:
            # What is both matte and a mirror is the end of a path wherever light from diffuse surface to diffuse
            # surface is left out.
            raise job.Cannot("it has no mirrored floor without indirect diffuse light")
        self.order = order
        self.scene = build(still)

    def render(self, samples, seed, threads):
        config = pyluxcore.RenderConfig(settings(self.order, samples, seed, threads), self.scene)
        session = pyluxcore.RenderSession(config)
        session.Start()
        began = job.user_time()
        while not session.HasDone():
            # It checks whether it is done only when asked for its progress.
            session.UpdateStats()
            time.sleep(0.01)
        seconds = job.user_time() - began
        session.Stop()
        pixels = np.zeros(stills.WIDTH * stills.HEIGHT * 3, dtype=np.float32)
        session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, pixels)
        return pixels.reshape(stills.HEIGHT, stills.WIDTH, 3)[::-1], seconds


if __name__ == "__main__":
    pyluxcore.Init()
    job.serve(LuxCore)
