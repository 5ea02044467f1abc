"""Meshes of scenes/daylight.txt: upholstery and a curtain."""

import math

from board import bevelled_box
from mesh import Mesh, smoothstep


def cushion(size, bevel, puff):
    """A soft box: its broad sides swell by `puff`."""
    mesh = bevelled_box(size, bevel, 6)
    grid = refine(refine(refine(mesh)))

    def swell(p):
        x, y, z = (2 * a / s for a, s in zip(p, size))
        w = (1 - x ** 4) * (1 - y ** 4) if abs(x) < 1 and abs(y) < 1 else 0
        return (p[0], p[1], p[2] + math.copysign(puff * max(w, 0), p[2]) * smoothstep(.0, .5, abs(z)))
    grid.positions = [swell(p) for p in grid.positions]
    grid.normals = [None] * len(grid.positions)
    return weld(grid)


def refine(mesh):
    """Divides the long edges of the flat sides in two."""
    out = Mesh()
    out.positions, out.normals, out.uvs = list(mesh.positions), list(mesh.normals), list(mesh.uvs)
    halves = {}

    def half(a, b):
        key = tuple(sorted((mesh.positions[a], mesh.positions[b])))
        if math.dist(*key) < 9:
            return None
        if key not in halves:
            halves[key] = out.vertex(tuple((x + y) / 2 for x, y in zip(*key)))
        return halves[key]

    for a, b, c in mesh.faces:
        ab, bc, ca = half(a, b), half(b, c), half(c, a)
        corners = [i for i in (a, ab, b, bc, c, ca) if i is not None]
        if ab is not None and bc is not None and ca is not None:
            for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)):
                out.triangle(*t)
        else:
            start = corners.index(next((i for i in (ab, bc, ca) if i is not None), a))
            corners = corners[start:] + corners[:start]
            for i in range(1, len(corners) - 1):
                out.triangle(corners[0], corners[i], corners[i + 1])
    return out


def weld(mesh):
    out, ids = Mesh(), {}
    remap = []
    for p in mesh.positions:
        key = tuple(round(x, 3) for x in p)
        if key not in ids:
            ids[key] = out.vertex(p)
        remap.append(ids[key])
    for a, b, c in mesh.faces:
        if len({remap[a], remap[b], remap[c]}) == 3:
            out.triangle(remap[a], remap[b], remap[c])
    return out


def curtain():
    """A curtain in the yz plane, 60 cm wide and 236 cm high, gathered in folds."""
    mesh, ny, nz = Mesh(), 96, 14
    ids = []
    for k in range(nz + 1):
        z = 236 * k / nz
        for j in range(ny + 1):
            t = j / ny
            flare = 1 + .18 * (1 - k / nz) ** 2
            a = math.tau * (7.5 * t + .25 * math.sin(5 * t + 1) * (1 - .3 * k / nz))
            x = (4.2 * math.sin(a) + 1.2 * math.sin(.43 * a + 2)) * (.75 + .35 * (1 - k / nz))
            y = (t - .5) * 60 * flare + 1.6 * math.cos(a)
            ids.append(mesh.vertex((x, y, z), None, (t * 12, z / 20)))
    for k in range(nz):
        for j in range(ny):
            i = k * (ny + 1) + j
            mesh.quad(ids[i], ids[i + 1], ids[i + ny + 2], ids[i + ny + 1])
    return mesh


def build():
    cushion((74, 66, 17), 4.5, 2.2).write("sofa_seat", 2)
    cushion((74, 46, 17), 5.5, 3.0).write("sofa_back", 2)
    cushion((44, 44, 9), 4.0, 6.0).write("pillow", 2)
    bevelled_box((224, 88, 20), 2.5).write("sofa_base")
    bevelled_box((20, 90, 58), 5.0).write("sofa_arm")
    curtain().write("curtain", 2)


if __name__ == "__main__":
    build()
