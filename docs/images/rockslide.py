"""Draws one frame of a run of scenes/rockslide.toml: python docs/images/rockslide.py RUN FRAME OUT.png

Needs numpy and zarr. Every boulder is drawn as a ball, coloured by its speed, over the ground that boulders have passed.
"""

import struct
import sys
import zlib

import numpy as np
import zarr

WIDTH, HEIGHT, MARGIN = 1280, 720, 40
SUN = np.array([-0.35, -0.55, 0.76])


def png(path, image):
    """Writes an array of shape (height, width, 3), values 0 to 255."""
    rows = b"".join(b"\0" + row.tobytes() for row in image.astype(np.uint8))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", image.shape[1], image.shape[0], 8, 2, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def camera():
    """Right, up and forward of a view from beside and above the run-out."""
    forward = np.array([-0.1, 0.9, -0.5])
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(right, forward), forward])


def draw(image, depth, centers, radii, colors):
    """Balls with shading and depth, in pixels."""
    view = camera()
    light = view @ SUN
    for (x, y, z), r, color in zip(centers, radii, colors):
        left, top = int(x - r), int(y - r)
        size = int(2 * r) + 2
        if left < 0 or top < 0 or left + size > WIDTH or top + size > HEIGHT:
            continue
        v, u = np.mgrid[top : top + size, left : left + size]
        u, v = (u - x) / r, (v - y) / r
        inside = 1 - u * u - v * v
        out = np.sqrt(np.clip(inside, 0, None))
        shade = np.clip(u * light[0] - v * light[1] - out * light[2], 0, 1)
        there = z - out * r
        box = (slice(top, top + size), slice(left, left + size))
        hit = (inside > 0) & (there < depth[box])
        depth[box][hit] = there[hit]
        image[box][hit] = (color * (0.25 + 0.85 * shade[..., None]))[hit]


def main(run, frame, path):
    store = zarr.open(f"{run}/trajectory.zarr", mode="r")
    track = np.array(store["position"][:, 1:])
    now = track[frame]
    speed = np.linalg.norm(track[frame] - track[frame - 1], axis=1) * 60
    # The ground is where boulders have been: their lowest place over each metre.
    paths = track[::3].reshape(-1, 3)
    cells, where = np.unique(np.floor(paths[:, :2]).astype(int), axis=0, return_inverse=True)
    low = np.full(len(cells), np.inf)
    np.minimum.at(low, where.ravel(), paths[:, 2])
    ground = np.column_stack([cells + 0.5, low - 0.9])

    view = camera()
    seen, soil = now @ view.T, ground @ view.T
    corner, span = soil[:, :2].min(0), np.ptp(soil[:, :2], axis=0)
    zoom = min((WIDTH - 2 * MARGIN) / span[0], (HEIGHT - 2 * MARGIN) / span[1])

    def pixels(p):
        x = (p[:, 0] - corner[0]) * zoom + (WIDTH - span[0] * zoom) / 2
        y = HEIGHT - MARGIN - (p[:, 1] - corner[1]) * zoom
        return np.column_stack([x, y, p[:, 2] * zoom])

    sky = np.linspace([118, 150, 186], [226, 232, 236], HEIGHT)
    image = np.repeat(sky[:, None, :], WIDTH, axis=1)
    depth = np.full((HEIGHT, WIDTH), np.inf)
    tint = np.array([126, 118, 104]) + 10 * np.sin(ground[:, 2:3])
    draw(image, depth, pixels(soil), np.full(len(soil), 1.1 * zoom), tint)
    heat = np.clip(speed / 25, 0, 1)[:, None]
    colors = (1 - heat) * np.array([150, 142, 132]) + heat * np.array([222, 118, 52])
    draw(image, depth, pixels(seen), np.full(len(seen), 0.5 * zoom), colors)
    png(path, np.clip(image, 0, 255))


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), sys.argv[3])
