"""Scenes of physical light, as data from which the scene of each renderer is made.

Every value stands here once: geometry, camera, materials, lamps and sky. Lengths are metres, colours linear, and
radiance is in W/(m^2 sr). Rectangles are three consecutive corners; the fourth is v0 + v2 - v1. A lamp that is a
rectangle shines along (v1 - v0) x (v2 - v1).
"""

from dataclasses import dataclass, field, replace

import numpy as np

WIDTH, HEIGHT = 256, 144
SHUTTER_SLICES = 16  # poses of moving objects in renderers without motion blur


# Materials.

@dataclass(frozen=True)
class Matte:
    """Lambert."""
    color: tuple


@dataclass(frozen=True)
class Metal:
    """GGX with Schlick's Fresnel."""
    color: tuple
    roughness: float


@dataclass(frozen=True)
class Glass:
    """GGX with the exact Fresnel of dielectrics; a roughness of 0 is clear."""
    roughness: float
    ior: float = 1.5


@dataclass(frozen=True)
class Plastic:
    """Lambert under a rough dielectric."""
    color: tuple
    roughness: float


@dataclass(frozen=True)
class Coat:
    """A metal under a rough dielectric coat."""
    color: tuple
    roughness: float
    coat_roughness: float


@dataclass(frozen=True)
class Glow:
    """A black surface with this radiance on its outside."""
    radiance: tuple


# Shapes.

@dataclass(frozen=True)
class Rectangle:
    v0: tuple
    v1: tuple
    v2: tuple

    def frame(self):
        """Centre and half edges."""
        v0, v1, v2 = map(np.float64, (self.v0, self.v1, self.v2))
        return (v0 + v2) / 2, (v1 - v0) / 2, (v2 - v1) / 2

    def corners(self):
        v0, v1, v2 = map(np.float64, (self.v0, self.v1, self.v2))
        return np.array([v0, v1, v2, v0 + v2 - v1])


@dataclass(frozen=True)
class Sphere:
    center: tuple
    radius: float


@dataclass(frozen=True, eq=False)
class Mesh:
    vertices: np.ndarray
    faces: np.ndarray
    normals: np.ndarray | None = None  # of the vertices, if they are interpolated


@dataclass(frozen=True)
class Thing:
    """`keys` are (pivot, up, right) at the opening and the closing of the shutter."""
    name: str
    shape: object
    material: object
    keys: tuple = ()

    def pose(self, time):
        """Returns the matrix from object to world space at a shutter time from 0 to 1."""
        if not self.keys:
            return np.eye(4)
        first, last = self.keys[0], self.keys[-1]
        pivot, up, right = (np.float64(a) + time * (np.float64(b) - a) for a, b in zip(first, last))
        right /= np.linalg.norm(right)
        up -= right * (up @ right)
        up /= np.linalg.norm(up)
        matrix = np.eye(4)
        matrix[:3] = np.column_stack([right, np.cross(up, right), up, pivot])
        return matrix

    def moves(self):
        return len(self.keys) > 1


# Lamps.

@dataclass(frozen=True)
class RectangleLamp:
    radiance: tuple
    shape: Rectangle


@dataclass(frozen=True)
class SphereLamp:
    radiance: tuple
    center: tuple
    radius: float

    def power(self):
        return tuple(4 * np.pi**2 * self.radius**2 * c for c in self.radiance)


@dataclass(frozen=True)
class Sun:
    irradiance: tuple
    direction: tuple  # in which the light travels
    angle_deg: float  # diameter of the disc

    def radiance(self):
        return tuple(c / (np.pi * np.sin(np.radians(self.angle_deg) / 2) ** 2) for c in self.irradiance)


@dataclass(frozen=True)
class Sky:
    """`radiance` maps unit vectors, an array [..., 3], to colours [..., 3]."""
    radiance: object
    width: int

    def image(self, rows, columns=None):
        """The equirectangular map with its rows at these shares of the height."""
        columns = (np.arange(self.width) + 0.5) / self.width if columns is None else columns
        v, u = np.meshgrid(np.pi * rows, 2 * np.pi * (0.5 - columns), indexing="ij")
        ways = np.stack([np.sin(v) * np.cos(u), np.sin(v) * np.sin(u), np.cos(v)], axis=-1)
        return self.radiance(ways).astype(np.float32)

    def centered(self):
        """Row centres at (i + 0.5) / height."""
        height = self.width // 2
        return self.image((np.arange(height) + 0.5) / height)

    def at_poles(self):
        """The first and the last row at the poles."""
        height = self.width // 2
        return self.image(np.arange(height) / (height - 1))


@dataclass(frozen=True)
class Scene:
    name: str
    eye: tuple
    target: tuple
    fov: float  # half the height of the view at distance 1
    bounces: int  # after the first hit; lamps are asked at the last hit too
    things: tuple
    lamps: tuple = ()
    sky: Sky | None = None
    lens: float = 0.0
    focus: float = 1.0
    limit: float = 1e-3  # relative mean square error to reach
    same_light: bool = True  # Mitsuba has the same materials
    photons: float = 0.0  # slo-rt's light paths for each camera sample
    all_pixels: bool = False  # whether the limit is for all pixels, not for all but the worst

    def segments(self):
        """The depth as Mitsuba counts it: segments of the path, with the one to the lamp."""
        return self.bounces + 2

    def moves(self):
        return any(thing.moves() for thing in self.things)


# Geometry.

def knot(p=2, q=3, radius=0.42, swing=0.19, tube=0.13, along=640, around=40):
    """A torus knot around the z axis."""
    t = 2 * np.pi * np.arange(along) / along

    def curve(t):
        r = radius + swing * np.cos(q * t)
        return np.stack([r * np.cos(p * t), r * np.sin(p * t), swing * np.sin(q * t)], axis=-1)

    def unit(v):
        return v / np.linalg.norm(v, axis=-1, keepdims=True)

    ahead = unit(curve(t + 1e-4) - curve(t - 1e-4))
    out = unit(np.cross(ahead, (0.0, 0.0, 1.0)))
    up = np.cross(out, ahead)
    s = 2 * np.pi * np.arange(around) / around
    normals = out[:, None] * np.cos(s)[None, :, None] + up[:, None] * np.sin(s)[None, :, None]
    vertices = curve(t)[:, None] + tube * normals
    i, j = np.meshgrid(np.arange(along), np.arange(around), indexing="ij")
    a, b = i * around + j, (i + 1) % along * around + j
    c, d = (i + 1) % along * around + (j + 1) % around, i * around + (j + 1) % around
    faces = np.concatenate([np.stack([a, c, b], axis=-1), np.stack([a, d, c], axis=-1)]).reshape(-1, 3)
    return outward(Mesh(vertices.reshape(-1, 3), faces, normals.reshape(-1, 3)))


def lathe(profile, around=96):
    """A body of revolution around the z axis from points (radius, z) and normals of its outline, in its order."""
    (r, z), (nr, nz) = (np.moveaxis(np.asarray(part, float), -1, 0) for part in profile)
    s = 2 * np.pi * np.arange(around) / around
    vertices = np.stack([np.outer(r, np.cos(s)), np.outer(r, np.sin(s)), np.outer(z, np.ones(around))], axis=-1)
    normals = np.stack([np.outer(nr, np.cos(s)), np.outer(nr, np.sin(s)), np.outer(nz, np.ones(around))], axis=-1)
    i, j = np.meshgrid(np.arange(len(r) - 1), np.arange(around), indexing="ij")
    a, b = i * around + j, (i + 1) * around + j
    c, d = (i + 1) * around + (j + 1) % around, i * around + (j + 1) % around
    faces = np.concatenate([np.stack([a, c, b], axis=-1), np.stack([a, d, c], axis=-1)]).reshape(-1, 3)
    mesh = Mesh(vertices.reshape(-1, 3), faces, normals.reshape(-1, 3))
    corners = mesh.vertices[faces]
    return outward(replace(mesh, faces=faces[np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0],
                                                                       corners[:, 2] - corners[:, 0]), axis=1) > 1e-12]))


def ring(radius=0.5, height=0.3, thickness=0.03):
    """A band with a rounded edge, standing on its rim."""
    angles = np.linspace(0, 2 * np.pi, 65)
    nr, nz = np.cos(angles), np.sin(angles)
    r = radius + thickness * nr
    z = height / 2 + thickness * nz + (height / 2 - thickness) * np.sign(np.round(nz, 9))
    return lathe((np.stack([r, z], axis=-1), np.stack([nr, nz], axis=-1)))


def lens(radius=0.3, curvature=0.5):
    """Two caps of spheres."""
    height = np.sqrt(curvature**2 - radius**2)
    angles = np.linspace(0, np.arcsin(radius / curvature), 33)
    sine, cosine = np.sin(angles), np.cos(angles)
    points = [np.stack([curvature * sine, sign * (curvature * cosine - height)], axis=-1) for sign in (1, -1)]
    normals = [np.stack([sine, sign * cosine], axis=-1) for sign in (1, -1)]
    return lathe((np.concatenate([points[0], points[1][::-1]]), np.concatenate([normals[0], normals[1][::-1]])))


def outward(mesh):
    """Turns faces whose corners go clockwise seen from outside."""
    a, b, c = (mesh.vertices[mesh.faces[:, corner]] for corner in range(3))
    if np.einsum("ij,ij", np.cross(b - a, c - a), mesh.normals[mesh.faces[:, 0]]) < 0:
        return replace(mesh, faces=mesh.faces[:, ::-1])
    return mesh


def block(size):
    """A box around the origin with hard edges."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * np.float64(size) / 2
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return Mesh(corners, np.array([f for a, b, c, d in quads for f in ((a, b, c), (a, c, d))]))


def joined(meshes):
    """One mesh without normals."""
    offsets = np.cumsum([0] + [len(mesh.vertices) for mesh in meshes[:-1]])
    return Mesh(np.concatenate([mesh.vertices for mesh in meshes]),
                np.concatenate([mesh.faces + offset for mesh, offset in zip(meshes, offsets)]))


def tetrahedron(center, size, rng):
    vertices = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) * size
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    return Mesh(vertices @ turn.T + center, np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]))


def walls(low, high, colors, leave=()):
    """The inside of a box; `colors` and `leave` name its faces by x0, x1, y0, y1, z0, z1."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    faces = {
        "x0": ((x0, y0, z0), (x0, y1, z0), (x0, y1, z1)), "x1": ((x1, y0, z0), (x1, y0, z1), (x1, y1, z1)),
        "y0": ((x0, y0, z0), (x0, y0, z1), (x1, y0, z1)), "y1": ((x0, y1, z0), (x1, y1, z0), (x1, y1, z1)),
        "z0": ((x0, y0, z0), (x1, y0, z0), (x1, y1, z0)), "z1": ((x0, y0, z1), (x0, y1, z1), (x1, y1, z1)),
    }
    return [Thing(f"wall_{face}", Rectangle(*corners), Matte(colors.get(face, WALL)))
            for face, corners in faces.items() if face not in leave]


# Scenes.

WALL, RED, GREEN, WOOD = (0.72, 0.7, 0.66), (0.6, 0.12, 0.1), (0.15, 0.42, 0.2), (0.45, 0.3, 0.18)
LOW, HIGH = (-2.0, -3.0, 0.0), (2.0, 2.0, 2.6)
CEILING_LAMP = RectangleLamp((14.0, 13.0, 11.0), Rectangle((-0.6, -0.4, 2.58), (-0.6, 0.4, 2.58), (0.6, 0.4, 2.58)))
UPRIGHT = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
LEANING = ((0.5, -0.75, 0.45), (0.85, 0.5, 0.1))


def room():
    """A closed room with one lamp and a torus knot, all of it matte."""
    things = walls(LOW, HIGH, {"x0": RED, "x1": GREEN, "z0": WOOD}) + [
        Thing("knot", knot(), Matte((0.75, 0.62, 0.35)), (((0.15, 0.4, 1.05), *LEANING),)),
        Thing("ball", Sphere((-1.1, 0.9, 0.45), 0.45), Matte((0.3, 0.4, 0.75))),
        Thing("table", block((0.8, 0.8, 0.4)), Matte((0.7, 0.7, 0.7)), (((1.1, 0.6, 0.2), (0, 0, 1), (0.9, 0.4, 0)),)),
    ]
    return Scene("room", (0.1, -2.85, 1.4), (0.05, 0.6, 1.05), 0.5, 8, tuple(things), (CEILING_LAMP,), limit=1e-3)


def motion():
    """The room with a turning knot, a flying block and a wide lens."""
    still = room()
    things = [thing for thing in still.things if thing.name not in ("knot", "table")] + [
        Thing("knot", knot(), Matte((0.75, 0.62, 0.35)),
              (((0.05, 0.4, 1.0), *LEANING), ((0.3, 0.3, 1.15), (0.75, -0.55, 0.35), (0.6, 0.8, 0.1)))),
        Thing("table", block((0.5, 0.5, 0.4)), Matte((0.7, 0.7, 0.7)),
              (((0.9, -0.5, 0.5), (0, 0, 1), (1, 0.2, 0)), ((1.3, -0.4, 0.8), (0.3, 0, 1), (0.8, 0.7, 0)))),
    ]
    return replace(still, name="motion", things=tuple(things), lens=0.06, focus=3.3, limit=2e-3)


def evening(ways):
    """A smooth gradient over a dark ground."""
    height = ways[..., 2:]
    zenith, horizon, ground = np.array([0.25, 0.5, 1.2]), np.array([1.6, 1.3, 1.1]), np.array([0.12, 0.1, 0.08])
    share = np.clip(height, 0, 1) ** 0.5
    sky = horizon * (1 - share) + zenith * share
    glow = 0.5 * (1 + ways @ (np.array([0.8, 0.55, 0.25]) / np.linalg.norm([0.8, 0.55, 0.25])))
    sky = sky * (0.6 + 1.2 * glow[..., None] ** 6)
    blend = np.clip(0.5 + height / 0.08, 0, 1)
    return ground * (1 - blend) + sky * blend


def window():
    """A room with sky and sun through a window, and a glossy knot."""
    x = HIGH[0]
    (y0, y1), (z0, z1) = (-0.9, 1.1), (0.8, 2.15)
    around = [((LOW[1], 0), (y0, 2.6)), ((y1, 0), (2, 2.6)), ((y0, 0), (y1, z0)), ((y0, z1), (y1, 2.6))]
    things = walls(LOW, HIGH, {"x0": (0.65, 0.55, 0.45), "z0": WOOD}, leave=("x1",)) + [
        Thing(f"window_{number}", Rectangle((x, ya, za), (x, ya, zb), (x, yb, zb)), Matte(WALL))
        for number, ((ya, za), (yb, zb)) in enumerate(around)
    ] + [
        Thing("knot", knot(), Metal((0.95, 0.72, 0.42), 0.25), (((0.25, 0.35, 0.8), *LEANING),)),
        Thing("ball", Sphere((-0.75, 0.9, 0.4), 0.4), Matte((0.25, 0.4, 0.65))),
    ]
    sun = Sun((22.0, 19.0, 15.0), (-0.8, -0.42, -0.52), 0.53)
    return Scene("window", (-1.5, -2.7, 1.45), (0.35, 0.6, 0.95), 0.48, 8, tuple(things), (sun,), Sky(evening, 512),
                 limit=3e-2)


def hall():
    """A hall with 1000 spheres and 1000 rectangles as lamps, and 500 glowing triangles."""
    rng = np.random.default_rng(7)
    low, high = (-5.0, -2.0, 0.0), (5.0, 20.0, 4.5)
    things = walls(low, high, {"z0": (0.5, 0.48, 0.45), "z1": (0.35, 0.36, 0.4), "y1": (0.6, 0.5, 0.4)})
    for number, (x, y) in enumerate((x, y) for y in (3.0, 8.0, 13.0) for x in (-2.6, 2.6)):
        things.append(Thing(f"pillar_{number}", block((0.6, 0.6, 4.5)), Matte((0.7, 0.66, 0.6)),
                            (((x, y, 2.25), *UPRIGHT),)))
    things.append(Thing("knot", knot(radius=0.8, swing=0.35, tube=0.24), Matte((0.7, 0.7, 0.72)),
                        (((0.0, 4.5, 1.4), *LEANING),)))

    def free(x, y, z):
        """Whether the point is not in a pillar, near the knot, or near the camera."""
        pillar = abs(abs(x) - 2.6) < 0.5 and min(abs(y - row) for row in (3.0, 8.0, 13.0)) < 0.5
        return not pillar and np.hypot(np.hypot(x, y - 4.5), z - 1.4) > 1.6 and np.hypot(np.hypot(x, y + 1.5), z - 1.7) > 1.5

    def places(count):
        points = []
        while len(points) < count:
            point = rng.uniform(np.add(low, 0.2), np.subtract(high, 0.2))
            if free(*point):
                points.append(point)
        return points

    def radiance(scale):
        tint = np.array([1.0, 0.8, 0.5]) + rng.random() * np.array([-0.5, 0.0, 0.5])
        return tuple(scale * 10 ** rng.uniform(-0.5, 0.5) * tint)

    lamps = [SphereLamp(radiance(4.0), tuple(place), 0.02 + 0.02 * rng.random()) for place in places(1000)]
    for place in places(1000):
        a = rng.normal(size=3)
        b = np.cross(a, rng.normal(size=3))
        a, b = 0.05 * a / np.linalg.norm(a), 0.05 * b / np.linalg.norm(b)
        lamps.append(RectangleLamp(radiance(4.5), Rectangle(*map(tuple, (place - a - b, place + a - b, place + a + b)))))
    colors = [(3.0, 1.5, 0.75), (1.0, 2.0, 3.0), (2.5, 2.5, 2.0), (2.5, 1.0, 2.0), (1.0, 2.5, 1.0)]
    for number, color in enumerate(colors):
        mesh = joined([tetrahedron(place, 0.05, rng) for place in places(25)])
        things.append(Thing(f"glow_{number}", mesh, Glow(color)))
    return Scene("hall", (0.3, -1.6, 1.7), (0.0, 6.0, 1.5), 0.5, 2, tuple(things), tuple(lamps), limit=2e-2)


SUN_WAY = np.array([-0.55, -0.45, 0.62]) / np.linalg.norm([-0.55, -0.45, 0.62])


def sunny(ways):
    """A gradient with a bright disc of 2 degrees."""
    height = ways[..., 2:]
    zenith, horizon, ground = np.array([0.2, 0.4, 0.95]), np.array([0.9, 0.95, 1.0]), np.array([0.2, 0.18, 0.16])
    share = np.clip(height, 0, 1) ** 0.6
    blend = np.clip(0.5 + height / 0.1, 0, 1)
    sky = ground * (1 - blend) + (horizon * (1 - share) + zenith * share) * blend
    off = np.degrees(np.arccos(np.clip(ways @ SUN_WAY, -1, 1)))[..., None]
    return sky + np.array([2600.0, 2400.0, 2000.0]) * np.clip((1.0 - off) / 0.25 + 0.5, 0, 1)


GOLD = (1.0, 0.78, 0.34)


def table(name, shapes, **more):
    things = [Thing("ground", Rectangle((-30, -30, 0), (30, -30, 0), (30, 30, 0)), Matte((0.4, 0.38, 0.36)))] + shapes
    return Scene(name, (0.0, -5.2, 2.3), (0.0, 0.1, 0.55), 0.33, 8, tuple(things), (), Sky(sunny, 2048), **more)


def stills():
    """Rough gold, glass, plastic and coat under a sky with a small sun."""
    return table("stills", [
        Thing("gold", knot(), Metal(GOLD, 0.3), (((-1.55, 0.5, 0.62), *LEANING),)),
        Thing("glass", Sphere((-0.35, -0.5, 0.5), 0.5), Glass(0.2)),
        Thing("plastic", Sphere((0.7, 0.4, 0.55), 0.55), Plastic((0.15, 0.3, 0.6), 0.3)),
        Thing("coat", Sphere((1.75, -0.3, 0.5), 0.5), Coat((0.7, 0.15, 0.1), 0.3, 0.1)),
    ], limit=2e-3, same_light=False)


def microfacets():
    """What Mitsuba has just so: metal and glass of little roughness under the same sky."""
    return table("microfacets", [
        Thing("gold", knot(), Metal(GOLD, 0.2), (((-1.55, 0.5, 0.62), *LEANING),)),
        Thing("rough_glass", Sphere((-0.35, -0.5, 0.5), 0.5), Glass(0.2)),
        Thing("silver", Sphere((0.7, 0.4, 0.55), 0.55), Metal((0.9, 0.9, 0.9), 0.1)),
        Thing("matte", Sphere((1.75, -0.3, 0.5), 0.5), Matte((0.7, 0.15, 0.1))),
    ], limit=2e-3)


def caustics():
    """A glass ball, a metal ring and a lens on a table under a small lamp; the ring's caustic is seen through the ball."""
    lamp = RectangleLamp((900.0, 850.0, 750.0), Rectangle((0.85, 1.45, 3.2), (0.85, 1.55, 3.2), (0.95, 1.55, 3.2)))
    things = [
        Thing("table", Rectangle((-6, -6, 0), (6, -6, 0), (6, 6, 0)), Matte((0.6, 0.55, 0.5))),
        Thing("ball", Sphere((-0.15, -0.55, 0.42), 0.42), Glass(0.0)),
        Thing("ring", ring(), Metal(GOLD, 0.0), (((0.35, 0.5, 0.0), *UPRIGHT),)),
        Thing("lens", lens(), Glass(0.0), (((-1.0, 0.2, 0.75), (0.25, 0.35, 1.0), (1.0, 0.0, -0.25)),)),
    ]
    return Scene("caustics", (0.0, -3.4, 1.9), (-0.1, 0.0, 0.25), 0.38, 12, tuple(things), (lamp,), limit=1e-2,
                 photons=0.5, all_pixels=True)


SCENES = {make.__name__: make for make in (room, window, hall, stills, motion, microfacets, caustics)}


def scene(name):
    return SCENES[name]()
