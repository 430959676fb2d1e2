"""Draws one body of each kind of shape on a floor: python docs/images/shapes.py OUT.png

Needs numpy. Shapes are traced through their signed distances, or estimates that are never too large.
"""

import sys

import numpy as np
from rockslide import SUN, png

WIDTH, HEIGHT = 1024, 420
EYE, LOOK, ZOOM = np.array([0.0, -9.5, 5.6]), np.array([0.0, 0.35, 0.3]), 2.05
STONE = np.array([196, 178, 150])


def length(p):
    return np.sqrt((p * p).sum(-1))


def box(half):
    def distance(p):
        q = np.abs(p) - half
        return length(np.maximum(q, 0)) + np.minimum(q.max(-1), 0)

    return distance


def grown(shape, radius):
    return lambda p: shape(p) - radius


def sphere(radius):
    return lambda p: length(p) - radius


def capsule(half, radius):
    def distance(p):
        q = p.copy()
        q[..., 2] -= np.clip(p[..., 2], -half, half)
        return length(q) - radius

    return distance


def frustum(half, lower, upper):
    side = np.array([2 * half, lower - upper]) / np.hypot(2 * half, lower - upper)

    def distance(p):
        across = np.hypot(p[..., 0], p[..., 1])
        slope = side[0] * (across - lower) + side[1] * (p[..., 2] + half)
        return np.maximum(slope, np.abs(p[..., 2]) - half)

    return distance


def ellipsoid(half):
    half = np.array(half)

    def distance(p):
        level = length(p / half)
        return (level - 1) * half.min()

    return distance


def hull(normals, offsets):
    normals = np.array(normals, float)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return lambda p: (p @ normals.T - offsets).max(-1)


def rounded_hull(normals, offsets, radius):
    """The faces moved out by the radius and blended over it."""
    normals = np.array(normals, float)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    sharp = 2.5 / radius

    def distance(p):
        faces = p @ normals.T - offsets - radius
        high = faces.max(-1)
        return high + np.log(np.exp(sharp * (faces - high[..., None])).sum(-1)) / sharp

    return distance


def turned(shape, place, z=0, x=0):
    """The shape turned by x about x and then by z about z, in a place."""
    (c, s), (d, t) = (np.cos(z), np.sin(z)), (np.cos(x), np.sin(x))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, d, -t], [0, t, d]])
    return lambda p: shape((p - place) @ turn)


def hills(x, y):
    return 0.3 + 0.16 * np.sin(3.1 * x) * np.cos(2.7 * y) + 0.08 * np.sin(5 * y + x)


def height_field(middle):
    """A square of hills; the slope is at most 1, so half of the height is safe."""

    def distance(p):
        q = p - middle
        out = np.abs(q[..., :2]).max(-1) - 0.62
        return np.maximum((q[..., 2] - hills(q[..., 0], q[..., 1])) * 0.6, out)

    return distance


def mesh(middle):
    """A torus, which no convex shape is."""

    def distance(p):
        q = p - middle
        ring = np.hypot(q[..., 0], q[..., 1]) - 0.42
        return np.hypot(ring, q[..., 2]) - 0.17

    return distance


def scene():
    wedge = hull([[0, 0, -1], [0, 1, 0], [0, -1, 0], [-1, 0, 0.25], [1, 0.2, 0.9], [0.5, -0.3, 1]], [0.3, 0.34, 0.34, 0.36, 0.34, 0.32])
    gem = rounded_hull([[0, 0, -1], [0, 0, 1], [1, 0.4, 0.3], [-1, 0.3, 0.2], [0.2, 1, 0.3], [-0.3, -1, 0.2]], [0.2, 0.22, 0.26, 0.26, 0.2, 0.24], 0.14)
    back, front = 1.35, -0.75
    row = np.linspace(-3.9, 3.9, 6)
    return [
        (turned(sphere(0.5), [row[0], back, 0.5]), [205, 92, 80]),
        (turned(box([0.5, 0.4, 0.45]), [row[1], back, 0.45], 0.5), [214, 150, 72]),
        (turned(capsule(0.4, 0.28), [row[2], back, 0.28], 0.6, np.pi / 2), [198, 178, 80]),
        (turned(frustum(0.5, 0.4, 0.4), [row[3], back, 0.5]), [120, 168, 96]),
        (turned(frustum(0.55, 0.48, 0.0), [row[4], back, 0.55]), [86, 160, 142]),
        (turned(frustum(0.4, 0.34, 0.5), [row[5], back, 0.4]), [86, 140, 176]),
        (turned(ellipsoid([0.65, 0.45, 0.3]), [row[0], front, 0.3], 0.4), [110, 116, 184]),
        (turned(grown(box([0.36, 0.3, 0.3]), 0.13), [row[1], front, 0.43], 0.5), [150, 108, 176]),
        (turned(wedge, [row[2], front, 0.3], 0.4), [184, 104, 150]),
        (turned(gem, [row[3], front, 0.34], 0.3), [196, 112, 112]),
        (mesh(np.array([row[4], front, 0.17])), [150, 150, 156]),
        (height_field(np.array([row[5], front, 0.0])), [140, 152, 118]),
    ]


def nearest(bodies, p):
    distances = np.stack([body(p) for body, _ in bodies])
    return distances.min(0), distances.argmin(0)


def march(bodies, start, way, steps, far):
    """How far along each ray something is, and which body; far where there is nothing."""
    t = np.zeros(start.shape[:-1])
    which = np.zeros(t.shape, int)
    for _ in range(steps):
        gap, which = nearest(bodies, start + t[..., None] * way)
        t = np.minimum(t + np.where(gap > 1e-4, gap, 0), far)
    return t, which


def draw(path, bodies):
    forward = (LOOK - EYE) / np.linalg.norm(LOOK - EYE)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    # Two samples a side for each pixel.
    v, u = np.mgrid[0 : 2 * HEIGHT, 0 : 2 * WIDTH] / WIDTH - np.array([HEIGHT, WIDTH])[:, None, None] / WIDTH
    sun = SUN / np.linalg.norm(SUN)
    image = np.empty((2 * HEIGHT, 2 * WIDTH, 3))
    for band in range(0, 2 * HEIGHT, 80):
        part = slice(band, band + 80)
        way = forward * ZOOM + u[part, :, None] * right - v[part, :, None] * up
        way /= length(way)[..., None]
        ground = np.where(way[..., 2] < 0, -EYE[2] / np.minimum(way[..., 2], -1e-9), 60)
        eye = np.broadcast_to(EYE, way.shape)
        t, which = march(bodies, eye, way, 45, np.minimum(ground, 60))
        p = EYE + t[..., None] * way
        on_ground = t >= ground - 1e-3
        e = 1e-3
        slope = np.stack([nearest(bodies, p + e * a)[0] - nearest(bodies, p - e * a)[0] for a in np.eye(3)], -1)
        normal = np.where(on_ground[..., None], [0, 0, 1], slope / np.maximum(length(slope), 1e-9)[..., None])
        colors = np.array([color for _, color in bodies], float)[which]
        tiles = (np.floor(p[..., 0]) + np.floor(p[..., 1])) % 2
        colors = np.where(on_ground[..., None], STONE + 10 * tiles[..., None], colors)
        lit = np.clip(normal @ sun, 0, 1)
        # Soft shade: how near the way to the sun comes to anything.
        shade = np.ones(lit.shape)
        q, s = p + 2e-3 * normal, np.full(lit.shape, 0.02)
        for _ in range(16):
            gap, _ = nearest(bodies, q + s[..., None] * sun)
            shade = np.minimum(shade, np.clip(8 * gap / s, 0, 1))
            s = s + np.clip(gap, 0.03, 0.6)
        image[part] = colors * (0.34 + 0.72 * lit * shade)[..., None]
    small = image.reshape(HEIGHT, 2, WIDTH, 2, 3).mean((1, 3))
    # Fewer shades make a smaller file.
    png(path, np.clip(np.round(small / 4) * 4, 0, 255))


if __name__ == "__main__":
    draw(sys.argv[1], scene())
