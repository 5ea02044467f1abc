# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads scene texts and moves things by the rules of docs/scene-format.md.

Written from the document, not from the exporter, so that it can check the exporter.
"""

import math
import re

import numpy as np


class Block:
    """An element or block: `values` of attributes by name (lists), `inner` blocks in order."""

    def __init__(self, kind, name):
        self.kind = kind
        self.name = name
        self.values = {}
        self.inner = []

    def all(self, kind):
        """Inner elements of a kind, or blocks of a name."""
        return [block for block in self.inner if (block.kind or block.name) == kind]

    def one(self, kind, name=None):
        """The one inner element of a kind (and a name)."""
        found = [b for b in self.all(kind) if name is None or b.name == name]
        assert len(found) == 1, (kind, name, [b.name for b in self.all(kind)])
        return found[0]

    def number(self, name, otherwise=None):
        """The number of an attribute."""
        return float(self.values[name][0][0]) if name in self.values else otherwise

    def vectors(self, name):
        """All vectors of an attribute that may be repeated."""
        return [[float(word) for word in words] for words in self.values.get(name, [])]

    def vector(self, name, otherwise=None):
        """The vector of an attribute."""
        return self.vectors(name)[0] if name in self.values else otherwise


def read(text):
    """The scene as a block without a name."""
    text = re.sub(r"(?m)(^|(?<=[\s{}]))#.*$", "", text)
    words = re.sub(r"([{}])", r" \1 ", text).split()
    scene = Block("", "")
    rest = _inside(words, 0, scene)
    assert rest == len(words), "one } too many"
    return scene


def _inside(words, at, block):
    while at < len(words) and words[at] != "}":
        if words[at + 1] == "{" and _is_number(words[at + 2]):
            end = words.index("}", at)
            block.values.setdefault(words[at], []).append(words[at + 2 : end])
            at = end + 1
        elif words[at + 1] == "{":
            at = _block(words, at + 2, block, Block("", words[at]))
        elif at + 2 < len(words) and words[at + 2] == "{":
            at = _block(words, at + 3, block, Block(words[at], words[at + 1]))
        else:
            block.values.setdefault(words[at], []).append([words[at + 1]])
            at += 2
    return at


def _block(words, at, outer, inner):
    at = _inside(words, at, inner)
    assert words[at] == "}", "an open block"
    outer.inner.append(inner)
    return at + 1


def _is_number(word):
    try:
        float(word)
    except ValueError:
        return False
    return True


def bezier(points, u):
    """The point at `u` of a Bézier curve, by de Casteljau."""
    while len(points) > 1:
        points = [mix(a, b, u) for a, b in zip(points, points[1:])]
    return points[0]


def mix(a, b, u):
    """Between two vectors, linearly."""
    return [x + (y - x) * u for x, y in zip(a, b)]


def cross(a, b):
    """Vector product."""
    return [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]


def unit(a):
    """The vector at length 1."""
    length = math.sqrt(sum(x * x for x in a))
    return [x / length for x in a]


def placement(thing, time):
    """`(pivot, [right, forward, up])` of an element at scene time `time` in seconds."""
    return whole_placement(thing, time)[:2]


def matrix(scene, thing, time):
    """The matrix (4, 4) to world space of an element at a scene time, with all that it hangs in."""
    pivot, axes, scale = whole_placement(thing, time)
    result = np.eye(4)
    result[:3, :3] = np.transpose(axes) * scale
    result[:3, 3] = pivot
    if "parent" in thing.values:
        name = thing.values["parent"][0][0]
        parents = [
            block for block in scene.inner if block.name == name and block.kind != "material"
        ]
        result = matrix(scene, parents[0], time) @ result
    return result


def whole_placement(thing, time):
    """`(pivot, [right, forward, up], scale)` of an element at scene time `time` in seconds."""
    frames = [_key(block) for block in thing.all("addKframe")]
    previous = {"pivot": [0.0] * 3, "up": [0.0, 0.0, 1.0], "right": [1.0, 0.0, 0.0]}
    previous["scale"] = [1.0] * 3
    for frame in frames:
        previous = {name: frame["key"].get(name, previous[name]) for name in previous}
        frame["key"] = previous
    if not frames:
        values = previous
    elif time <= frames[0]["time"]:
        values = frames[0]["key"]
    elif time >= frames[-1]["time"]:
        values = frames[-1]["key"]
    else:
        values = _between(frames, time)
    right = unit(values["right"])
    along = sum(a * b for a, b in zip(values["up"], right))
    up = unit([a - along * b for a, b in zip(values["up"], right)])
    return values["pivot"], [right, cross(up, right), up], values["scale"]


def _key(block):
    def vectors(name):
        parts = block.all(name)
        return {n: parts[0].vector(n) for n in parts[0].values} if parts else {}

    return {"time": block.number("time"), **{n: vectors(n) for n in ("pre", "key", "nex")}}


def _between(frames, time):
    for a, b in zip(frames, frames[1:]):
        if a["time"] <= time <= b["time"]:
            u = (time - a["time"]) / (b["time"] - a["time"])
            return {n: bezier(_control(a, b, n), u) for n in ("pivot", "up", "right", "scale")}
    raise AssertionError("key frames out of order")


def _control(a, b, name):
    start, end = a["key"][name], b["key"][name]
    leave = a["nex"].get(name) or mix(start, end, 1.0 / 3.0)
    arrive = b["pre"].get(name) or mix(start, end, 2.0 / 3.0)
    return [start, leave, arrive, end]


def camera(scene, frame, shutter):
    """Returns the camera at `shutter` (0 to 1) of a frame: position, forward, up, fov, dof, lens
    radius, and the scene time in seconds."""
    element = scene.all("Camera")[0]
    fps = element.number("fps")
    segments = element.all("CamSegment")
    last = max(segment.number("videoEnd") for segment in segments)
    start = frame / fps
    for segment in segments:
        begin, end = segment.number("videoStart"), segment.number("videoEnd")
        if begin - 1e-6 <= start < end - 1e-6 or (end == last and abs(start - end) < 1e-6):
            break
    else:
        raise AssertionError(f"frame {frame} is in no segment")
    time = min(start + shutter * segment.number("blurDuration", 0.0), end)
    u = (time - begin) / (end - begin)
    position = bezier(segment.vectors("addPosition"), u)
    target = bezier(segment.vectors("addTarget"), u)
    sky_start = segment.vector("skyStart", [0.0, 0.0, 1.0])
    sky = mix(sky_start, segment.vector("skyEnd", sky_start), u)
    forward = unit([b - a for a, b in zip(position, target)])
    right = unit(cross(forward, sky))

    def linear(name):
        first = segment.number(f"{name}Start", 0.0)
        return first + (segment.number(f"{name}End", first) - first) * u

    scene_start = segment.number("sceneStart", begin)
    scene_end = segment.number("sceneEnd", scene_start + end - begin)
    return {
        "position": position,
        "forward": forward,
        "up": cross(right, forward),
        "fov": linear("fov"),
        "dof": linear("dof"),
        "lens_radius": linear("lensRadius"),
        "time": scene_start + (scene_end - scene_start) * u,
    }


def shapes(thing):
    """Times and filenames of the shapes of a mesh."""
    found = [
        (block.number("time"), block.values["filename"][0][0]) for block in thing.all("addShape")
    ]
    for block in thing.all("shapes"):
        pattern = block.values["filename"][0][0]
        digits = pattern.count("#")
        first, last = int(block.number("first")), int(block.number("last"))
        for number in range(first, last + 1):
            time = block.number("time", 0.0) + (number - first) / block.number("fps")
            found.append((time, pattern.replace("#" * digits, f"{number:0{digits}d}")))
    return found


def ply(path):
    """The columns of the vertices of a binary `.ply` file by name, and its triangles or None."""
    with open(path, "rb") as file:
        data = file.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    lines = data[:end].decode().split("\n")
    assert lines[1] == "format binary_little_endian 1.0"
    counts = {line.split()[1]: int(line.split()[2]) for line in lines if line.startswith("element")}
    names = [line.split()[2] for line in lines if line.startswith("property float")]
    size = 4 * len(names) * counts["vertex"]
    vertices = np.frombuffer(data[end : end + size], "<f4").reshape(-1, len(names))
    rest = np.frombuffer(data[end + size :], np.uint8)
    faces = None
    if "face" in counts:
        rest = rest.reshape(counts["face"], 13)
        assert (rest[:, 0] == 3).all()
        faces = np.ascontiguousarray(rest[:, 1:]).view("<i4")
    else:
        assert not rest.size
    return dict(zip(names, vertices.T.astype(np.float64))), faces
