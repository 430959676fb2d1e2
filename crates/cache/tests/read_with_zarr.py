"""Opens a trajectory with Python's zarr and xarray and compares every value with those that the Rust test wrote beside it.

Usage: read_with_zarr.py TRAJECTORY EXPECTED

EXPECTED holds raw little-endian arrays: position.f32, orientation.f32, time.f64, id.u64, shape.u32, scale.f32, and
names.txt with one name per line; velocity.f32 where the run has a bound of 0.1 mm and 0.1 degrees, and velocities.
"""

import sys
import warnings
from pathlib import Path

import numpy as np
import xarray
import zarr

# Delta and shuffle are codecs of numcodecs, which comes with zarr; it says so whenever it meets them.
warnings.filterwarnings("ignore", message="Numcodecs codecs are not in the Zarr version 3 specification")

MOVING = {"position": ("frame", "body", "xyz"), "orientation": ("frame", "body", "xyzw")}


def main(trajectory: Path, expected: Path) -> None:
    group = zarr.open_group(trajectory, mode="r")
    dataset = xarray.open_zarr(trajectory, consolidated=False)
    bounded = (expected / "velocity.f32").exists()
    assert group.metadata.zarr_format == 3
    assert group.attrs["rockfall_trajectory"] == 2
    assert group.attrs["origin"] == [4.0e6, -2.0e6, 100.0]
    names = ["hash", "id", "name", "orientation", "position", "scale", "shape", "time"]
    assert sorted(group.array_keys()) == sorted(names + ["angular_velocity", "velocity"] * bounded)

    def raw(name: str, dtype: str) -> np.ndarray:
        return np.fromfile(expected / name, dtype=dtype)

    time = raw("time.f64", "<f8")
    ids = raw("id.u64", "<u8")
    frames, bodies = len(time), len(ids)
    cases = {
        "time": (time, ("frame",)),
        "hash": (np.arange(frames, dtype="<u8"), ("frame",)),
        "id": (ids, ("body",)),
        "shape": (raw("shape.u32", "<u4"), ("body",)),
        "scale": (raw("scale.f32", "<f4"), ("body",)),
    }
    poses = {
        "position": raw("position.f32", "<f4").reshape(frames, bodies, 3),
        "orientation": raw("orientation.f32", "<f4").reshape(frames, bodies, 4),
    }
    if bounded:
        cases["velocity"] = (raw("velocity.f32", "<f4").reshape(frames, bodies, 3), ("frame", "body", "xyz"))
        assert group.attrs["scene"] == "seed = 1\n" and group.attrs["rockfall"] == "0.1.0"
    else:
        cases |= {name: (values, MOVING[name]) for name, values in poses.items()}
    for name, (values, dimensions) in cases.items():
        array = group[name]
        assert array.metadata.dimension_names == dimensions, name
        assert dataset[name].dims == dimensions, name
        assert array.dtype == values.dtype, (name, array.dtype)
        assert array.shape == values.shape, (name, array.shape)
        np.testing.assert_array_equal(array[:], values, err_msg=name)
        np.testing.assert_array_equal(dataset[name].values, values, err_msg=name)
    assert list(group["name"][:]) == (expected / "names.txt").read_text(encoding="utf-8").split("\n")

    # xarray applies the factor and the number for what is absent by itself.
    read = {name: dataset[name].values.astype(float) for name in MOVING}
    for name, dimensions in MOVING.items():
        assert dataset[name].dims == group[name].metadata.dimension_names == dimensions, name
        assert (np.isnan(read[name]) == np.isnan(poses[name])).all(), name
    assert np.isnan(read["position"][0]).any(), "the run should have bodies that come later"
    assert dataset["position"].attrs["units"] == "m"
    if bounded:
        assert group["position"].dtype == np.int32 and group["orientation"].dtype == np.int16
        way = np.linalg.norm(read["position"] - poses["position"], axis=2)
        unit = read["orientation"] / np.linalg.norm(read["orientation"], axis=2, keepdims=True)
        turn = 4 * np.arcsin(np.linalg.norm(unit - poses["orientation"], axis=2) / 2)
        assert np.nanmax(way) <= 1e-4, np.nanmax(way)
        assert np.nanmax(turn) <= np.radians(0.1), np.nanmax(turn)
    print(f"{frames} frames of {bodies} bodies are {'within the bound' if bounded else 'equal'}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
