"""Draws bodies that only a field can be: python docs/images/fields.py OUT.png

Needs numpy. A chain that hangs on a peg, bowls that stand in each other, balls in a cup, rings on the floor.
"""

import sys

import numpy as np
from shapes import draw, frustum, length, sphere, turned


def torus(ring, tube):
    return lambda p: np.hypot(np.hypot(p[..., 0], p[..., 1]) - ring, p[..., 2]) - tube


def bowl(radius, wall):
    """A half shell with a flat foot, its rim at z = 0."""

    def distance(p):
        shell = np.abs(length(p) - radius + wall / 2) - wall / 2
        foot = np.maximum(length(p) - radius, p[..., 2] + 0.86 * radius)
        whole = np.minimum(shell, foot)
        return np.maximum(np.maximum(whole, p[..., 2]), -p[..., 2] - 0.9 * radius)

    return distance


def cup(radius, height, wall):
    def distance(p):
        across = np.hypot(p[..., 0], p[..., 1])
        outside = np.maximum(across - radius, np.abs(p[..., 2] - height / 2) - height / 2)
        inside = np.maximum(across - radius + wall, wall - p[..., 2])
        handle = np.hypot(np.hypot(p[..., 0] - radius - 0.08, p[..., 2] - height / 2) - 0.26, p[..., 1]) - 0.07
        return np.maximum(np.minimum(outside, handle), -inside)

    return distance


def scene():
    colors = [[205, 92, 80], [214, 150, 72], [198, 178, 80], [120, 168, 96], [86, 160, 142], [86, 140, 176], [110, 116, 184], [150, 108, 176]]
    bodies = [(turned(frustum(0.9, 0.12, 0.12), [-2.9, 0.6, 2.28], 0, np.pi / 2), [150, 150, 156])]
    for k in range(4):
        # Each hangs lower by the width of a hole.
        place = [-2.9, 0.6, 1.9 - 0.5 * k]
        upright = (np.pi / 2 if k % 2 else 0, np.pi / 2)
        bodies.append((turned(torus(0.34, 0.09), place, *upright), colors[k]))
    for k in range(5):
        bodies.append((turned(bowl(0.75, 0.05), [-0.6, 0.4, 0.655 + 0.274 * k]), colors[(k + 3) % 8]))
    bodies.append((turned(cup(0.62, 1.05, 0.07), [1.5, 0.5, 0.0], -0.6), [196, 190, 180]))
    places = [[1.3, 0.35, 0.32], [1.72, 0.45, 0.33], [1.4, 0.78, 0.34], [1.62, 0.62, 0.72], [1.3, 0.4, 0.8], [1.5, 0.6, 1.1]]
    bodies += [(turned(sphere(0.24), place), colors[k]) for k, place in enumerate(places)]
    for k, (x, y) in enumerate([[3.2, 0.7], [3.9, -0.1], [3.0, -0.6]]):
        bodies.append((turned(torus(0.42, 0.15), [x, y, 0.15], 0.3 * k), colors[(2 * k + 4) % 8]))
    bodies.append((turned(torus(0.42, 0.15), [3.42, 0.05, 0.43], 0.4, 0.05), colors[1]))
    return bodies


if __name__ == "__main__":
    draw(sys.argv[1], scene())
