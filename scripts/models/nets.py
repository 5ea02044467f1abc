"""Surface nets: the zero surface of a function on a grid, refined by Newton steps.

Source: Gibson 1998, "Constrained elastic surface nets". Here vertices move to the surface along the
gradient instead of relaxing.
"""

from mesh import Mesh, add, mul, unit, dot

CORNERS = [(i & 1, i >> 1 & 1, i >> 2 & 1) for i in range(8)]


def surface(field, low, high, cell):
    """Mesh of field = 0 (negative inside) in a box; the field must be positive on its border."""
    counts = [int((h - l) / cell) + 2 for l, h in zip(low, high)]
    nx, ny, nz = counts

    def point(i, j, k):
        return (low[0] + i * cell, low[1] + j * cell, low[2] + k * cell)

    inside = [[[field(point(i, j, k)) < 0.0 for i in range(nx)] for j in range(ny)]
              for k in range(nz)]
    mesh, ids = Mesh(), {}
    for k in range(nz - 1):
        for j in range(ny - 1):
            for i in range(nx - 1):
                signs = [inside[k + c][j + b][i + a] for a, b, c in CORNERS]
                if any(signs) and not all(signs):
                    start = point(i + .5, j + .5, k + .5)
                    ids[i, j, k] = mesh.vertex(*settle(field, start, cell))
    connect(mesh, ids, inside, counts)
    return mesh


def gradient(field, p, h):
    return tuple((field(add(p, e)) - field(add(p, mul(e, -1.0)))) / (2.0 * h)
                 for e in ((h, 0.0, 0.0), (0.0, h, 0.0), (0.0, 0.0, h)))


def settle(field, p, cell):
    """The point reached by a few damped Newton steps, and the unit gradient there."""
    start = p
    for _ in range(4):
        g = gradient(field, p, cell * .1)
        step = mul(g, -field(p) / max(dot(g, g), 1e-4))
        size = dot(step, step) ** .5
        p = add(p, mul(step, min(1.0, .4 * cell / max(size, 1e-9))))
        p = tuple(min(max(x, s - .75 * cell), s + .75 * cell) for x, s in zip(p, start))
    return p, unit(gradient(field, p, cell * .3))


def connect(mesh, ids, inside, counts):
    """One quad per grid edge that crosses the surface."""
    nx, ny, nz = counts
    for k in range(1, nz - 1):
        for j in range(1, ny - 1):
            for i in range(1, nx - 1):
                here = inside[k][j][i]
                for axis, there in ((0, inside[k][j][i + 1]), (1, inside[k][j + 1][i]),
                                    (2, inside[k + 1][j][i])):
                    if here == there:
                        continue
                    quad = [ids[c] for c in around(i, j, k, axis)]
                    mesh.quad(*(quad if here else quad[::-1]))


def around(i, j, k, axis):
    """The four cells about a grid edge, counter-clockwise about its direction."""
    if axis == 0:
        return [(i, j - 1, k - 1), (i, j, k - 1), (i, j, k), (i, j - 1, k)]
    if axis == 1:
        return [(i - 1, j, k - 1), (i - 1, j, k), (i, j, k), (i, j, k - 1)]
    return [(i - 1, j - 1, k), (i, j - 1, k), (i, j, k), (i - 1, j, k)]
