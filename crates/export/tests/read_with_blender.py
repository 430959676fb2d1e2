"""Imports a USD export into Blender and compares every instance with the trajectory, which Python's zarr reads.

Usage: read_with_blender.py RUN FILE FRAMES

FILE is the one to open, FRAMES are the numbers that were exported, with commas between. Bodies with ids from 6000 on are static, and all but two of them are instances.
"""

import sys
from pathlib import Path

import bpy
import numpy as np
import zarr

STATIC = {1: "Body_1", 2: "Body_2", 3: "post"}
SINGLE = {6001: "Body_6001", 6003: "Instances_2"}
CROWD = 6000


def matrices(positions: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Columns for vectors that stand behind them."""
    x, y, z, w = np.moveaxis(turns.astype(float), -1, 0)
    out = np.zeros((len(positions), 4, 4))
    out[:, :3, 0] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], -1)
    out[:, :3, 1] = np.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)], -1)
    out[:, :3, 2] = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], -1)
    out[:, :3, 3], out[:, 3, 3] = positions, 1
    return out


def compare(found: np.ndarray, want: np.ndarray, origin: np.ndarray) -> None:
    """Blender has single precision, and reads orientations of half precision."""
    spacing = np.spacing(np.abs(origin).max().astype("f4"))
    np.testing.assert_allclose(found[:, :3, :3], want[:, :3, :3], atol=2e-3)
    np.testing.assert_allclose(found[:, :3, 3], origin + want[:, :3, 3], rtol=1e-6, atol=1e-6 + spacing)


def main(run_path: Path, file: str, frames: list[int]) -> None:
    run = zarr.open_group(run_path / "trajectory.zarr", mode="r")
    origin = np.array(run.attrs["origin"])
    ids, shapes = run["id"][:], run["shape"][:]
    names_of_fixed = STATIC | SINGLE
    fixed = np.isin(ids, list(names_of_fixed))
    crowd = (ids >= CROWD) & ~fixed
    moving = ~fixed & ~crowd

    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert bpy.ops.wm.usd_import(filepath=file) == {"FINISHED"}
    scene = bpy.context.scene
    assert (scene.frame_start, scene.frame_end) == (frames[0], frames[-1])
    colors = set()
    for object in bpy.data.objects:
        if object.type == "MESH":
            (material,) = object.data.materials
            colors.add(tuple(material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value))
    assert len(colors) == (6 if crowd.any() else 5), colors

    for frame in frames:
        scene.frame_set(frame)
        names, found, still, alike = [], [], [], []
        for instance in bpy.context.evaluated_depsgraph_get().object_instances:
            if instance.is_instance and instance.parent.name.startswith("Instances"):
                alike.append(np.array(instance.matrix_world))
            elif instance.is_instance:
                names.append(int(instance.instance_object.name.split("_")[1]))
                found.append(np.array(instance.matrix_world))
            elif instance.object.type == "MESH" and instance.object.parent.name == "Static":
                still.append((instance.object.name, np.array(instance.matrix_world)))
        position, turn = run["position"][frame], run["orientation"][frame]
        there = ~np.isnan(position[:, 0])
        rows = np.flatnonzero(there & moving)
        assert names == list(shapes[rows]), (frame, len(names), len(rows))
        compare(np.array(found), matrices(position[rows], turn[rows]), origin)
        if len(still) != fixed.sum() or len(alike) != crowd.sum():
            raise AssertionError(f"{len(still)} and {len(alike)} static bodies")
        # Blender has objects by their names.
        places = dict(still)
        still = np.array([places[names_of_fixed[id]] for id in ids[fixed]])
        compare(still, matrices(position[fixed], turn[fixed]), origin)
        if alike:
            # Those of one look follow those of another; places tell who is who.
            want = matrices(position[crowd], turn[crowd])
            nearest = [np.abs(want[:, :3, 3] + origin - one[:3, 3]).sum(1).argmin() for one in alike]
            assert sorted(nearest) == list(range(len(alike)))
            compare(np.array(alike), want[nearest], origin)
    print(f"{len(frames)} frames of {len(ids)} bodies are equal")


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], [int(n) for n in sys.argv[3].split(",")])
