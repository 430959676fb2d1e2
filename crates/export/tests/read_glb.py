"""Reads a .glb by the letter of its specification and compares every pose with the trajectory, which Python's zarr reads.

Usage: read_glb.py RUN FILE FIRST    (FIRST is the run's number of the first frame that was exported)
"""

import json
import struct
import sys
from pathlib import Path

import numpy as np
import zarr

TYPES = {5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}


class Glb:
    def __init__(self, path: Path):
        data = path.read_bytes()
        magic, version, length = struct.unpack_from("<4sII", data)
        assert (magic, version, length) == (b"glTF", 2, len(data))
        size, kind = struct.unpack_from("<I4s", data, 12)
        assert kind == b"JSON" and size % 4 == 0
        self.json = json.loads(data[20 : 20 + size])
        more, kind = struct.unpack_from("<I4s", data, 20 + size)
        assert kind == b"BIN\0" and more == len(data) - size - 28
        self.binary = data[28 + size :]

    def numbers(self, index: int) -> np.ndarray:
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        width = WIDTHS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        count = accessor["count"] * width
        values = np.frombuffer(self.binary, TYPES[accessor["componentType"]], count, start)
        return values.reshape(-1, width) if width > 1 else values


def still(glb: Glb, run, frame: int) -> int:
    position, orientation, ids = run["position"][frame], run["orientation"][frame], run["id"]
    shapes, seen = run["shape"], []
    meshes = set()
    for node in glb.json["nodes"][:-1]:
        attributes = node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
        rows = np.searchsorted(ids, glb.numbers(attributes["_ID"]))
        np.testing.assert_array_equal(glb.numbers(attributes["TRANSLATION"]), position[rows])
        np.testing.assert_array_equal(glb.numbers(attributes["ROTATION"]), orientation[rows])
        name = glb.json["meshes"][node["mesh"]]["name"]
        assert name == f"shape {shapes[rows[0]]}" and (shapes[rows] == shapes[rows[0]]).all()
        # Bodies that look alike share a node.
        assert node["mesh"] not in meshes
        meshes.add(node["mesh"])
        seen.extend(rows)
    np.testing.assert_array_equal(np.sort(seen), np.flatnonzero(~np.isnan(position[:, 0])))
    return len(seen)


def animation(glb: Glb, run, first: int) -> int:
    position, orientation, ids = run["position"][first:], run["orientation"][first:], run["id"]
    time = (run["time"][first:] - run["time"][first]).astype("f4")
    frames = len(time)
    animation = glb.json["animations"][0]
    channels = {}
    for channel in animation["channels"]:
        sampler = animation["samplers"][channel["sampler"]]
        channels[channel["target"]["node"], channel["target"]["path"]] = sampler
    seen = []
    for index, node in enumerate(glb.json["nodes"][:-1]):
        row = np.searchsorted(ids, node["extras"]["id"])
        name = run["name"][row] or f"body {ids[row]}"
        assert node["name"] == name, (node["name"], name)
        there = ~np.isnan(position[:, row, 0])
        seen.append(row)
        if (index, "translation") not in channels:
            # One that nobody moves.
            assert there.all() and (position[:, row] == position[0, row]).all()
            np.testing.assert_allclose(node["translation"], position[0, row], atol=1e-7)
            continue
        for path, store in [("translation", position), ("rotation", orientation)]:
            sampler = channels[index, path]
            assert sampler["interpolation"] == "LINEAR"
            np.testing.assert_array_equal(glb.numbers(sampler["input"]), time)
            found = glb.numbers(sampler["output"])
            expected = store[:, row]
            if path == "rotation":
                # Either of the two quaternions of a rotation, and never the long way.
                assert (np.sum(found[1:] * found[:-1], axis=1) >= 0).all()
                expected = np.where(np.sum(found * expected, axis=1, keepdims=True) < 0, -expected, expected)
            np.testing.assert_array_equal(found[there], expected[there])
            assert np.isfinite(found).all() and len(found) == frames
            np.testing.assert_allclose(np.abs(node[path]), np.abs(found[0]), atol=1e-7)
        size = np.ones(frames)
        if (index, "scale") in channels:
            sampler = channels[index, "scale"]
            assert sampler["interpolation"] == "STEP"
            key = np.searchsorted(glb.numbers(sampler["input"]), time, side="right") - 1
            size = glb.numbers(sampler["output"])[key, 0]
            assert node.get("scale", [1, 1, 1])[0] == size[0]
        np.testing.assert_array_equal(size == 1, there)
    # Bodies that are never there have no node.
    np.testing.assert_array_equal(np.sort(seen), np.flatnonzero(~np.isnan(position[:, :, 0]).all(axis=0)))
    return frames


def main(run_path: Path, file: Path, first: int) -> None:
    group = zarr.open_group(run_path / "trajectory.zarr", mode="r")
    run = {name: group[name][:] for name in group.array_keys()}
    glb = Glb(file)
    root = glb.json["nodes"][-1]
    assert glb.json["scenes"] == [{"nodes": [len(glb.json["nodes"]) - 1]}]
    assert root["children"] == list(range(len(glb.json["nodes"]) - 1))
    assert root["extras"]["origin_m"] == group.attrs["origin"]
    # What was up, z, becomes y.
    x, y, z, w = root["rotation"]
    up = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    np.testing.assert_allclose(up, [0, 1, 0], atol=1e-12)
    if "animations" in glb.json:
        print(f"{animation(glb, run, first)} frames of {len(glb.json['nodes']) - 1} bodies are equal")
    else:
        print(f"1 frames of {still(glb, run, first)} bodies are equal")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]))
