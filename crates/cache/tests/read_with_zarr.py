"""Opens a trajectory with Python's zarr and compares every value with those that the Rust test wrote beside it.

Usage: read_with_zarr.py TRAJECTORY EXPECTED

EXPECTED holds raw little-endian arrays: position.f32, orientation.f32, time.f64, id.u64, shape.u32, scale.f32, and
names.txt with one name per line.
"""

import sys
from pathlib import Path

import numpy as np
import zarr


def main(trajectory: Path, expected: Path) -> None:
    group = zarr.open_group(trajectory, mode="r")
    assert group.metadata.zarr_format == 3
    assert group.attrs["rockfall_trajectory"] == 1
    assert group.attrs["origin"] == [4.0e6, -2.0e6, 100.0]
    assert sorted(group.array_keys()) == ["id", "name", "orientation", "position", "scale", "shape", "time"]

    def raw(name: str, dtype: str) -> np.ndarray:
        return np.fromfile(expected / name, dtype=dtype)

    time = raw("time.f64", "<f8")
    ids = raw("id.u64", "<u8")
    frames, bodies = len(time), len(ids)
    cases = {
        "position": (raw("position.f32", "<f4").reshape(frames, bodies, 3), ("frame", "body", "xyz")),
        "orientation": (raw("orientation.f32", "<f4").reshape(frames, bodies, 4), ("frame", "body", "xyzw")),
        "time": (time, ("frame",)),
        "id": (ids, ("body",)),
        "shape": (raw("shape.u32", "<u4"), ("body",)),
        "scale": (raw("scale.f32", "<f4"), ("body",)),
    }
    for name, (values, dimensions) in cases.items():
        array = group[name]
        assert array.metadata.dimension_names == dimensions, name
        assert array.dtype == values.dtype, (name, array.dtype)
        assert array.shape == values.shape, (name, array.shape)
        np.testing.assert_array_equal(array[:], values, err_msg=name)
    assert np.isnan(group["position"][0]).any(), "the run should have bodies that come later"

    names = (expected / "names.txt").read_text(encoding="utf-8").split("\n")
    assert list(group["name"][:]) == names
    print(f"{frames} frames of {bodies} bodies are equal")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
