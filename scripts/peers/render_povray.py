"""POV-Ray. Its processor time is its own measurement, without parsing. No motion blur, no moving meshes."""

import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np

import job
import stills


GRID = 2  # points of the lamp for each sample, in each direction


def vector(values):
    return "<" + ", ".join(f"{v:.7g}" for v in values) + ">"


def listed(values):
    return f"{len(values)}, " + ", ".join(map(vector, values))


def pigment(color):
    return f"pigment {{ color rgb {vector(color)} }} finish {{ diffuse 1 ambient 0 }}"


def mesh(name):
    vertices, faces, normals = stills.mesh(name)
    place, color = stills.MESHES[name]
    return f"""mesh2 {{ vertex_vectors {{ {listed(vertices)} }} normal_vectors {{ {listed(normals)} }}
 face_indices {{ {listed(faces)} }} {pigment(color)} translate {vector(place)} }}
"""


def camera(still, samples):
    right, up, forward = stills.camera_frame()
    ratio = stills.WIDTH / stills.HEIGHT
    blur = ""
    if still.lens:
        # This confidence is never reached, so each pixel takes all samples.
        blur = f"""aperture {2 * still.lens} blur_samples {samples}, {samples} confidence 0.999999 variance 0
 focal_point {vector(np.add(stills.EYE, stills.FOCUS * forward))}"""
    return f"""camera {{ perspective location {vector(stills.EYE)} direction {vector(forward)}
 right {vector(2 * stills.FOV * ratio * right)} up {vector(2 * stills.FOV * up)} {blur} }}
"""


def scene_text(still, samples, grid):
    center, a, b = stills.light_frame()
    # Points of the grid, which spans this rectangle from edge to edge, are jittered by up to half a step each way.
    a, b = (edge * (grid - 1) / grid for edge in (a, b))
    ball, radius, color = stills.BALL
    text = f"""#version 3.7;
global_settings {{ assumed_gamma 1 }}
background {{ rgb {vector(stills.SKY)} }}
light_source {{ {vector(center)} color rgb {vector(stills.LIGHT_COLOR)}
 area_light {vector(2 * a)}, {vector(2 * b)}, {grid}, {grid} jitter area_illumination on }}
plane {{ <0, 0, 1>, 0 {pigment(stills.FLOOR)} }}
sphere {{ {vector(ball)}, {radius} {pigment(color)} }}
"""
    return text + camera(still, samples) + "".join(map(mesh, stills.MESHES))


def read_ppm(path):
    """Reads a binary PPM file of 16 bits."""
    data = path.read_bytes()
    size = stills.WIDTH * stills.HEIGHT * 6
    return np.frombuffer(data[-size:], dtype=">u2").reshape(stills.HEIGHT, stills.WIDTH, 3) / np.float32(65535)


class PovRay:
    def __init__(self, still, order):
        if still.moves:
            raise job.Cannot("it has no motion blur")
        self.still, self.grid = still, order.get("grid", GRID)
        self.folder = tempfile.TemporaryDirectory()
        try:
            text = subprocess.run(["povray", "--version"], capture_output=True, text=True)
        except FileNotFoundError as error:
            job.missing(error)
        self.version = re.search(r"POV-Ray (\S+)", text.stdout + text.stderr).group(1)

    def render(self, samples, seed, threads):
        """Renders a picture. Without a lens, samples are rounded to a square. The block size serves as the seed."""
        scene, picture = (Path(self.folder.name) / name for name in ("still.pov", "still.ppm"))
        scene.write_text(scene_text(self.still, samples, self.grid), encoding="utf-8")
        command = ["povray", f"+I{scene}", f"+O{picture}", f"+W{stills.WIDTH}", f"+H{stills.HEIGHT}", "+FP16",
                   "File_Gamma=1.0", f"+BS{16 + seed % 97}", f"+WT{threads}", "-D", "-V"]
        if not self.still.lens:
            command += ["+AM1", "+A0.0", f"+R{round(samples**0.5)}", "+J1.0"]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        spent = re.search(r"Trace Time:[^\n]*?\n[^\n]*?([\d.]+) CPU-seconds", done.stdout + done.stderr)
        return read_ppm(picture), float(spent.group(1))


if __name__ == "__main__":
    job.serve(PovRay)
