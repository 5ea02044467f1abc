#!/usr/bin/env python3
# /// script
# requires-python = ">=3.10"
# dependencies = ["numpy"]
# ///
"""Writes a dragon of about 109 000 triangles, as a `.slo` mesh with normals.

    python3 scripts/models/dragon.py dragon.slo

The dragon is one closed surface, so that it may be made of glass: the zero surface of a function, found by surface
nets (Gibson 1998) on a grid whose cells are as large as the number of triangles asks for. The function is a smooth
union of round cones along the spine, the limbs, the horns and the spikes of the back, with scales. It stands on z = 0,
looks along -x, and is 1 long; the same bytes each time.

`scripts/reproduce/photon_mapping.py` renders it. It takes the place of the Stanford dragon, which has a license of its
own; it is not shipped, because it is made in seconds.
"""

import sys

import numpy as np

CELL = 0.00441  # gives about 109 000 triangles
BLEND = 0.012  # width of the seam between limbs
LENGTH = 3.0  # of the dragon as it is described below


def curve(points, count):
    """A Catmull-Rom curve through points (x, y, z, radius), as `count` points."""
    points = np.asarray(points, float)
    ends = np.concatenate([2 * points[:1] - points[1:2], points, 2 * points[-1:] - points[-2:-1]])
    t = np.linspace(0, len(points) - 1 - 1e-9, count)
    i, f = t.astype(int), (t % 1)[:, None]
    a, b, c, d = (ends[i + k] for k in range(4))
    made = 0.5 * (2 * b + (c - a) * f + (2 * a - 5 * b + 4 * c - d) * f**2 + (3 * (b - c) + d - a) * f**3)
    made[:, 3] = np.maximum(made[:, 3], 0.012)
    return made


def bones():
    """Chains of points (x, y, z, radius): spine, jaw, horns, limbs with claws, spikes of the back."""
    spine = curve(
        [
            (-1.50, -0.10, 0.98, 0.045),
            (-1.34, -0.08, 1.05, 0.085),
            (-1.14, -0.03, 1.14, 0.125),
            (-0.98, 0.02, 1.08, 0.12),
            (-0.90, 0.06, 0.88, 0.13),
            (-0.78, 0.08, 0.66, 0.17),
            (-0.48, 0.06, 0.58, 0.25),
            (-0.08, -0.02, 0.66, 0.28),
            (0.32, -0.06, 0.56, 0.26),
            (0.64, 0.00, 0.40, 0.20),
            (0.92, 0.16, 0.24, 0.14),
            (1.22, 0.34, 0.13, 0.105),
            (1.50, 0.26, 0.10, 0.085),
            (1.56, -0.06, 0.10, 0.07),
            (1.30, -0.30, 0.14, 0.055),
            (1.02, -0.30, 0.26, 0.04),
            (0.92, -0.20, 0.42, 0.025),
            (1.00, -0.14, 0.54, 0.012),
        ],
        150,
    )
    chains = [spine, curve([(-1.06, -0.02, 1.03, 0.08), (-1.22, -0.06, 0.95, 0.055), (-1.42, -0.10, 0.88, 0.03)], 10)]
    for side in (-1, 1):
        chains.append(
            curve(
                [
                    (-1.06, 0.0 + 0.06 * side, 1.22, 0.045),
                    (-0.92, 0.02 + 0.12 * side, 1.34, 0.032),
                    (-0.76, 0.02 + 0.13 * side, 1.37, 0.02),
                    (-0.64, 0.02 + 0.10 * side, 1.33, 0.008),
                ],
                14,
            )
        )
        chains.append(curve([(-1.22, -0.05 + 0.075 * side, 1.16, 0.035), (-1.17, -0.05 + 0.09 * side, 1.18, 0.03)], 4))
        for x, y, reach in ((-0.58, 0.05, -0.16), (0.42, -0.04, 0.10)):
            hip = (x, y + 0.17 * side, 0.46, 0.13)
            knee = (x + reach, y + 0.34 * side, 0.30, 0.085)
            ankle = (x + 0.05 * reach, y + 0.36 * side, 0.10, 0.055)
            foot = (x - 0.10, y + 0.37 * side, 0.045, 0.05)
            chains.append(curve([hip, knee, ankle, foot], 24))
            for spread in (-0.07, 0.0, 0.07):
                chains.append(
                    curve(
                        [
                            foot,
                            (x - 0.19, y + 0.37 * side + spread, 0.045, 0.03),
                            (x - 0.25, y + 0.37 * side + 1.3 * spread, 0.02, 0.010),
                        ],
                        8,
                    )
                )
    for point, ahead in zip(spine[26:140:6], spine[27:141:6]):
        along = (ahead - point)[:3] / np.linalg.norm((ahead - point)[:3])
        up = np.array([0, 0, 1.0]) - along * along[2]
        up /= np.linalg.norm(up)
        root, size = point[:3] + up * point[3] * 0.8, 0.06 + 0.55 * point[3]
        chains.append(np.array([(*root, 0.24 * size), (*(root + size * (0.75 * up + 0.35 * along)), 0.008)]))
    return chains


def round_cones(points):
    """Yields the ends (a, b) of all parts."""
    for chain in points:
        yield from zip(chain[:-1], chain[1:])


def distance(p, a, b):
    """Roughly the distance of points to a cone with round ends."""
    way = b[:3] - a[:3]
    t = np.clip((p - a[:3]) @ way / (way @ way), 0, 1)
    return np.linalg.norm(p - a[:3] - t[..., None] * way, axis=-1) - (a[3] + t * (b[3] - a[3]))


def joined(d, e):
    """Smooth minimum (Quilez)."""
    h = np.maximum(BLEND - np.abs(d - e), 0) / BLEND
    return np.minimum(d, e) - h * h * BLEND / 4


def scales(p):
    """How far scales stand out of the skin."""
    x, y, z = np.moveaxis(p, -1, 0)
    u, v = 42 * x + 6 * np.sin(5 * z), 42 * z + 21 * y
    return 0.006 * np.abs(np.sin(u + v) * np.sin(u - v)) - 0.003


class Field:
    """Negative inside of the dragon, which stands on z = 0 in its own size."""

    def __init__(self, low, high, cell):
        self.parts = list(round_cones(bones()))
        self.low, self.cell = low, cell
        self.counts = np.ceil((high - low) / cell).astype(int) + 1
        self.grid = np.full(self.counts, 10.0)
        margin = 0.05
        for a, b in self.parts:
            reach = max(a[3], b[3]) + margin
            first = np.maximum(((np.minimum(a, b)[:3] - reach - low) / cell).astype(int), 0)
            last = np.minimum(((np.maximum(a, b)[:3] + reach - low) / cell).astype(int) + 1, self.counts)
            window = tuple(slice(i, j) for i, j in zip(first, last))
            axes = [low[k] + cell * np.arange(first[k], last[k]) for k in range(3)]
            points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
            self.grid[window] = joined(self.grid[window], distance(points, a, b))
        axes = [low[k] + cell * np.arange(self.counts[k]) for k in range(3)]
        close = np.abs(self.grid) < margin
        self.grid[close] -= scales(np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)[close])

    def at(self, p):
        """The field and its gradient at points, by the cubic of the eight corners around them."""
        q = np.clip((p - self.low) / self.cell, 0, self.counts - 1.001)
        i, f = q.astype(int), q % 1
        value, slope = 0.0, np.zeros_like(p)
        for corner in np.ndindex(2, 2, 2):
            weights = [f[:, k] if corner[k] else 1 - f[:, k] for k in range(3)]
            sample = self.grid[tuple((i + corner).T)]
            value = value + sample * weights[0] * weights[1] * weights[2]
            for k in range(3):
                others = weights[(k + 1) % 3] * weights[(k + 2) % 3]
                slope[:, k] += sample * others * (1 if corner[k] else -1) / self.cell
        return value, slope


def net(field):
    """Vertices in cells that the surface crosses, and quads around edges that it crosses."""
    inside = field.grid < 0
    cells = np.zeros(field.counts - 1, int)
    for a, b, c in np.ndindex(2, 2, 2):
        cells += inside[a : a + cells.shape[0], b : b + cells.shape[1], c : c + cells.shape[2]]
    mixed = (cells > 0) & (cells < 8)
    ids = np.full(mixed.shape, -1)
    ids[mixed] = np.arange(np.count_nonzero(mixed))
    where = np.argwhere(mixed)
    # The mean of the places where the edges of a cell cross the surface.
    total, count = np.zeros((len(where), 3)), np.zeros((len(where), 1))
    for axis in range(3):
        for b, c in np.ndindex(2, 2):
            start = np.zeros(3, int)
            start[(axis + 1) % 3], start[(axis + 2) % 3] = b, c
            end = start.copy()
            end[axis] = 1
            d0, d1 = field.grid[tuple((where + start).T)], field.grid[tuple((where + end).T)]
            cross = (d0 < 0) != (d1 < 0)
            t = np.where(cross, d0 / np.where(cross, d0 - d1, 1), 0)[:, None]
            total += np.where(cross[:, None], start + t * (end - start), 0)
            count += cross[:, None]
    vertices = field.low + field.cell * (where + total / count)
    faces = []
    for axis in range(3):
        here, there = np.moveaxis(inside, axis, 0)[:-1], np.moveaxis(inside, axis, 0)[1:]
        edges = np.argwhere(here != there)
        edges = edges[(edges[:, 1:] > 0).all(axis=1)]
        flips = here[tuple(edges.T)]
        plane = np.moveaxis(ids, axis, 0)
        # The axes after `axis` in the moved array keep their order; for y it is not the cyclic one.
        ring = [plane[edges[:, 0], edges[:, 1] - b, edges[:, 2] - c] for b, c in ((1, 1), (0, 1), (0, 0), (1, 0))]
        quads = np.stack(ring, axis=-1)
        turned = flips if axis != 1 else ~flips
        quads[~turned] = quads[~turned][:, ::-1]
        faces += [quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]
    return vertices, np.concatenate(faces)


def smooth_normals(field, vertices):
    """Gradients of the field, blurred over half a cell so that they do not follow the grid."""
    total = np.zeros_like(vertices)
    for corner in np.ndindex(2, 2, 2):
        slope = field.at(vertices + (np.array(corner) - 0.5) * field.cell)[1]
        total += slope
    return total / np.linalg.norm(total, axis=1, keepdims=True)


def dragon(cell=CELL):
    """Returns vertices, normals and faces; 1 long, on z = 0."""
    low, high = np.array([-1.75, -0.75, -0.12]), np.array([1.80, 0.75, 1.55])
    field = Field(low, high, cell * LENGTH)
    vertices, faces = net(field)
    normals = smooth_normals(field, vertices)
    span = vertices[:, 0].max() - vertices[:, 0].min()
    middle = np.array([(vertices[:, 0].max() + vertices[:, 0].min()) / 2, 0, vertices[:, 2].min()])
    vertices = (vertices - middle) / span
    corners = vertices[faces]
    flat = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) < 1e-12
    return vertices, normals, faces[~flat]


def write(path, vertices, normals, faces):
    def rows(name, values, form):
        return f"{name} {{\n" + "\n".join(form % tuple(row) for row in values) + "\n}\n"

    text = "slo_mesh 1\n" + rows("vertices", vertices, "%.6f %.6f %.6f") + rows("normals", normals, "%.4f %.4f %.4f")
    with open(path, "w", encoding="ascii", newline="\n") as file:
        file.write(text + rows("faces", faces, "%d %d %d"))


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    parts = dragon()
    write(sys.argv[1], *parts)
    print(f"{sys.argv[1]}: {len(parts[0])} vertices, {len(parts[2])} faces")
