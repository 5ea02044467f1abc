"""The room of flicker.py: two glass balls, a lamp on the ceiling, a small lamp that rests and one that moves.

The same data as light_scenes.py; a frame is a still scene with the moving lamp at its place.
"""

from light_scenes import (
    GREEN,
    HIGH,
    LOW,
    RED,
    WOOD,
    Glass,
    Matte,
    Rectangle,
    RectangleLamp,
    Scene,
    Sphere,
    Thing,
    knot,
    walls,
)

FRAMES = 48
LEANING = ((0.5, -0.75, 0.45), (0.85, 0.5, 0.1))


def small_lamp(x, y, z, radiance, half=0.05):
    return RectangleLamp(radiance, Rectangle((x - half, y - half, z), (x - half, y + half, z), (x + half, y + half, z)))


def room(frame):
    """The scene at a frame from 0 to 47: the lamp over the ball on the right goes from left to right."""
    things = walls(LOW, HIGH, {"x0": RED, "x1": GREEN, "z0": WOOD}) + [
        Thing("knot", knot(along=320, around=24), Matte((0.75, 0.62, 0.35)), (((0.0, 1.1, 0.8), *LEANING),)),
        Thing("ball_still", Sphere((-0.95, -0.2, 0.4), 0.4), Glass(0.0)),
        Thing("ball_moving", Sphere((0.95, -0.2, 0.4), 0.4), Glass(0.0)),
    ]
    x = 0.55 + 0.9 * frame / (FRAMES - 1)
    lamps = (
        RectangleLamp((8.0, 7.5, 6.5), Rectangle((-0.6, -0.4, 2.58), (-0.6, 0.4, 2.58), (0.6, 0.4, 2.58))),
        small_lamp(-0.6, 0.3, 2.3, (130.0, 120.0, 90.0)),
        small_lamp(x, -0.1, 2.3, (90.0, 110.0, 130.0)),
    )
    return Scene("flicker", (0.1, -2.85, 1.5), (0.0, 0.5, 0.75), 0.45, 12, tuple(things), lamps)
