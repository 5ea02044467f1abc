"""Cutting convex solids by planes: the saw cut of the bishop's mitre."""

import math

from mesh import Mesh, add, cross, dot, lerp, mul, sub, unit


def split_convex(points, normals, plane):
    """The parts of a convex polygon in front of and behind dot(n, p) = d."""
    n, d = plane
    front, back = ([], []), ([], [])
    for i, p in enumerate(points):
        q = points[(i + 1) % len(points)]
        a, b = dot(n, p) - d, dot(n, q) - d
        for side, keep in ((front, a >= 0.0), (back, a <= 0.0)):
            if keep:
                side[0].append(p)
                side[1].append(normals[i])
        if a * b < 0.0:
            t = a / (a - b)
            x = lerp(p, q, t)
            m = unit(lerp(normals[i], normals[(i + 1) % len(points)], t))
            for side in (front, back):
                side[0].append(x)
                side[1].append(m)
    return front, back


def subtract(mesh, planes):
    """The mesh's surface without the part in front of all planes; open where it was cut."""
    mesh.compute_normals()
    out = Mesh()
    for face in mesh.faces:
        inside = ([mesh.positions[i] for i in face], [mesh.normals[i] for i in face])
        for plane in planes:
            inside, outside = split_convex(*inside, plane)
            fan(out, outside)
            if len(inside[0]) < 3:
                break
    return out


def fan(out, polygon):
    points, normals = polygon
    if len(points) < 3:
        return
    ids = [out.vertex(p, n) for p, n in zip(points, normals)]
    for i in range(1, len(ids) - 1):
        out.triangle(ids[0], ids[i], ids[i + 1])


def section(mesh, plane, others, up):
    """The solid's cross-section with a plane, clipped to the front of `others`, facing `up`."""
    n, d = plane
    points = []
    for face in mesh.faces:
        for k in range(3):
            p, q = mesh.positions[face[k]], mesh.positions[face[(k + 1) % 3]]
            a, b = dot(n, p) - d, dot(n, q) - d
            if a * b < 0.0:
                points.append(lerp(p, q, a / (a - b)))
    centre = mul(points[0], 0.0)
    for p in points:
        centre = add(centre, mul(p, 1.0 / len(points)))
    u = unit(cross(up, (0.3, 0.9, 0.1)))
    v = cross(up, u)
    points.sort(key=lambda p: math.atan2(dot(sub(p, centre), v), dot(sub(p, centre), u)))
    polygon = (points, [up] * len(points))
    for other in others:
        polygon, _ = split_convex(*polygon, other)
    out = Mesh()
    fan(out, polygon)
    return out
