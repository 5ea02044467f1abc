"""Four still lifes of shipped meshes, as numbers from which the scene of each renderer is made."""

import re
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]

WIDTH, HEIGHT = 640, 360
EYE, TARGET = (0, -34, 16), (0, 0, 3.4)
FOV = 0.3  # half the height of the view at distance 1
FOCUS = 35.0
# Three corners; it is seen from below.
LIGHT = ((-14, -10, 22), (-6, -14, 22), (-2, -6, 22))
LIGHT_COLOR = (1, 0.96, 0.9)
SKY = (0.05, 0.05, 0.06)
# Factor on the radiance of a lamp with falloff by distance, so that it lights the middle of the floor like a lamp of
# LIGHT_COLOR without falloff: pi r^2 / (area x cosine at the lamp).
RADIANCE = 22.0

WHITE, BLUE, RED = (0.8, 0.78, 0.74), (0.12, 0.2, 0.6), (0.7, 0.15, 0.1)
FLOOR, FLOOR_UNDER_MIRROR = (0.72, 0.7, 0.66), (0.35, 0.33, 0.3)
MIRROR = 0.4
# Spread of the lobes in slo-rt (cos^n about the mirrored ray, n = 1 / spread^2), and the roughness alpha of microfacets
# with the same appearance: their normals turn half as far as rays do.
MIRROR_SPREAD, GLASS_SPREAD = 0.15, 0.08
MIRROR_ALPHA = (2 / (4 / MIRROR_SPREAD**2 + 2)) ** 0.5
GLASS_ALPHA = (2 / (4 / GLASS_SPREAD**2 + 2)) ** 0.5
GLASS_INDEX = 1.5
BOUNCES = 4  # bounces after the first hit

MESHES = {
    "king": ((-3, 2, 0), WHITE),
    "pawn": ((7, -6, 0), BLUE),
    "rook": ((-9, 6, 0), WHITE),
    "bishop": ((9, 8, 0), BLUE),
    "knight": ((2.5, -3, 0), RED),
}
GLASS = "king"
MOVES = "knight"
BALL = ((-7, -5, 2), 2, RED)
# Pivot, up and right of the moving object at the two keys. The shutter opens at the first key and closes half way to
# the second.
KEYS = (((1, -3, 0), (0, 0, 1), (1, 0, 0)), ((5, -2, 2), (0.3, 0, 1), (0.5, 0.8, 0)))
SHUTTER = 0.5


class Still:
    """The contents of a still life."""

    def __init__(self, name):
        self.name = name
        self.lens = 0.0 if name == "S1" else 1.2
        self.moves = name in ("S3", "S4")
        self.rough = name == "S4"

    def pose(self, mesh, time=0.0):
        """Returns the matrix from mesh to world space at a shutter time from 0 to 1."""
        if self.moves and mesh == MOVES:
            return moving_pose(time * SHUTTER)
        matrix = np.eye(4)
        matrix[:3, 3] = MESHES[mesh][0]
        return matrix


STILLS = ("S1", "S2", "S3", "S4")


def moving_pose(u):
    pivot, up, right = (a + u * (b - a) for a, b in zip(*map(np.float64, KEYS)))
    right /= np.linalg.norm(right)
    up -= right * (up @ right)
    up /= np.linalg.norm(up)
    matrix = np.eye(4)
    matrix[:3] = np.column_stack([right, np.cross(up, right), up, pivot])
    return matrix


def mesh(name):
    """Returns vertices, triangles and vertex normals."""
    text = (ROOT / "meshes" / f"{name}.slo").read_text(encoding="utf-8")
    block = {key: re.search(rf"\b{key}\s*{{([^}}]*)}}", text).group(1) for key in ("vertices", "faces")}
    vertices = np.array(block["vertices"].split(), dtype=np.float64).reshape(-1, 3)
    faces = np.array(block["faces"].split(), dtype=np.int64).reshape(-1, 3)
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    normals = np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(normals, faces[:, corner], np.cross(b - a, c - a))
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-20)
    return vertices, faces, normals


def light_frame():
    """Centre of the lamp and its two half edges."""
    v0, v1, v2 = map(np.float64, LIGHT)
    return (v0 + v2) / 2, (v1 - v0) / 2, (v2 - v1) / 2


def camera_frame():
    """Right, up and forward, unit vectors."""
    forward = np.subtract(TARGET, EYE)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, (0, 0, 1))
    right /= np.linalg.norm(right)
    return right, np.cross(right, forward), forward
