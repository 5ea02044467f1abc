"""Reduces triangles where a closed surface is flat: edge collapse by quadric error.

Source: Garland and Heckbert 1997. An edge collapses to the best of its two ends and its middle.
"""

import heapq

from mesh import Mesh, add, cross, dot, length, mul, sub, unit


def decimate(mesh, target_vertices):
    """A mesh with about the given number of vertices (the caller computes normals)."""
    pos = list(mesh.positions)
    faces = [list(f) for f in mesh.faces]
    of_vertex = [set() for _ in pos]
    quadrics = [[0.0] * 10 for _ in pos]
    for f, face in enumerate(faces):
        q = plane_quadric(*(pos[i] for i in face))
        for i in face:
            of_vertex[i].add(f)
            quadrics[i] = [a + b for a, b in zip(quadrics[i], q)]
    stamp = [0] * len(pos)
    heap = []

    def push(a, b):
        cost, p = best_point(quadrics[a], quadrics[b], pos[a], pos[b])
        heapq.heappush(heap, (cost, min(a, b), max(a, b), stamp[a] + stamp[b], p))

    for f in faces:
        for a, b in ((f[0], f[1]), (f[1], f[2]), (f[2], f[0])):
            if a < b:
                push(a, b)
    left = sum(1 for s in of_vertex if s)
    while heap and left > target_vertices:
        _, a, b, mark, p = heapq.heappop(heap)
        if not of_vertex[a] or not of_vertex[b] or mark != stamp[a] + stamp[b]:
            continue
        if not collapsible(pos, faces, of_vertex, a, b, p):
            continue
        for f in of_vertex[b]:
            if a in faces[f]:
                for i in faces[f]:
                    if i != b:
                        of_vertex[i].discard(f)
                faces[f] = None
            else:
                faces[f][faces[f].index(b)] = a
                of_vertex[a].add(f)
        of_vertex[b] = set()
        pos[a] = p
        quadrics[a] = [x + y for x, y in zip(quadrics[a], quadrics[b])]
        ring = neighbours(faces, of_vertex, a)
        for i in [a, b]:
            stamp[i] += 1
        for i in ring:
            push(a, i)
        left -= 1
    out = Mesh()
    for p in pos:
        out.vertex(p)
    out.faces = [tuple(f) for f in faces if f]
    return out


def plane_quadric(p, q, r):
    """Squared distance to the plane, weighted by the triangle's area."""
    n = cross(sub(q, p), sub(r, p))
    area = length(n)
    n = unit(n)
    a, b, c = n
    d = -dot(n, p)
    return [area * x for x in (a * a, a * b, a * c, a * d, b * b, b * c, b * d, c * c, c * d,
                               d * d)]


def error(q, p):
    x, y, z = p
    return (q[0] * x * x + 2 * q[1] * x * y + 2 * q[2] * x * z + 2 * q[3] * x + q[4] * y * y
            + 2 * q[5] * y * z + 2 * q[6] * y + q[7] * z * z + 2 * q[8] * z + q[9])


def best_point(qa, qb, a, b):
    q = [x + y for x, y in zip(qa, qb)]
    short = length(sub(a, b)) ** 4 * 2e-4
    choices = [a, b, mul(add(a, b), .5)]
    errors = [max(error(q, p), 0.0) + short for p in choices]
    k = min(range(3), key=lambda i: (errors[i], i))
    return errors[k], choices[k]


def neighbours(faces, of_vertex, a):
    return sorted({i for f in of_vertex[a] for i in faces[f]} - {a})


def collapsible(pos, faces, of_vertex, a, b, p):
    """Whether a collapse makes no fold, no sliver and no change of topology."""
    shared = set(neighbours(faces, of_vertex, a)) & set(neighbours(faces, of_vertex, b))
    if len(shared) != 2:
        return False
    for v, other in ((a, b), (b, a)):
        for f in of_vertex[v]:
            if other in faces[f]:
                continue
            old = [pos[i] for i in faces[f]]
            new = [p if i == v else pos[i] for i in faces[f]]
            n0 = cross(sub(old[1], old[0]), sub(old[2], old[0]))
            n1 = cross(sub(new[1], new[0]), sub(new[2], new[0]))
            if dot(n0, n1) < .3 * length(n0) * length(n1) or length(n1) < 1e-9:
                return False
    return True
