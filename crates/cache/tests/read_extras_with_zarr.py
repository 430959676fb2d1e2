"""Opens contacts, events and columns of a trajectory with Python's zarr and xarray, and compares them with the formulas of `synthetic.rs`.

Usage: read_extras_with_zarr.py TRAJECTORY
"""

import sys
import warnings
from pathlib import Path

import numpy as np
import xarray
import zarr

# Shuffle is a codec of numcodecs, which comes with zarr; it says so whenever it meets it.
warnings.filterwarnings("ignore", message="Numcodecs codecs are not in the Zarr version 3 specification")


def rows(table, frame: int) -> slice:
    start = int(table["offset"][frame])
    return slice(start, start + int(table["count"][frame]))


def check_arrays(group, dataset, cases: dict) -> None:
    for name, (dtype, dimensions, units) in cases.items():
        array = group[name]
        assert array.dtype == dtype, (name, array.dtype)
        assert array.metadata.dimension_names == dataset[name].dims == dimensions, name
        assert array.attrs.get("units") == units, name
        np.testing.assert_array_equal(array[:], dataset[name].values, err_msg=name)


def main(path: Path) -> None:
    run = zarr.open_group(path, mode="r")
    frames, ids = run["time"].shape[0], run["id"][:]
    bodies = len(ids)
    dataset = xarray.open_zarr(path, consolidated=False)

    contacts = run["contacts"]
    vector = ("contact", "xyz")
    cases = {
        "offset": ("u8", ("frame",), None),
        "count": ("u4", ("frame",), None),
        "a": ("u8", ("contact",), None),
        "b": ("u8", ("contact",), None),
        "position": ("f4", vector, "m"),
        "normal": ("f4", vector, "1"),
        "distance": ("f4", ("contact",), "m"),
        "force": ("f4", ("contact",), "N"),
        "friction": ("f4", vector, "N"),
    }
    check_arrays(contacts, xarray.open_zarr(path, group="contacts", consolidated=False), cases)
    assert contacts.attrs["every"] == 1 and contacts.attrs["least_force_N"] == 2.5
    assert run.attrs["contacts"]["every"] == 1

    events = run["events"]
    cases = {name: (dtype, ("event",), None) for name, dtype in {"kind": "u1", "a": "u8", "b": "u8"}.items()}
    cases["impulse"] = ("f4", ("event",), "N s")
    check_arrays(events, xarray.open_zarr(path, group="events", consolidated=False), cases)
    assert run.attrs["events"] == events.attrs["events"] == "all"
    assert run.attrs["hits_N_s"] == events.attrs["hits_N_s"] == 4.5

    columns = {"heat": ("f4", "K"), "work": ("f8", "J"), "touched": ("u4", "1")}
    assert run.attrs["columns"] == list(columns)
    check_arrays(run, dataset, {name: (dtype, ("frame", "body"), units) for name, (dtype, units) in columns.items()})

    for frame in range(frames):
        here, k = rows(contacts, frame), np.arange(bodies if frame % 3 else 0)
        x = (k + frame / 8).astype("f4")
        np.testing.assert_array_equal(contacts["a"][here], 2 * k + 1)
        np.testing.assert_array_equal(contacts["b"][here], 2 * k + 3 + frame)
        np.testing.assert_array_equal(contacts["position"][here], np.stack([x, -x, np.full_like(x, 0.5)], 1))
        normals = np.array([[1, 0, 0], [0, -1, 0]], "f4")
        np.testing.assert_array_equal(contacts["normal"][here], normals[k % 2])
        np.testing.assert_array_equal(contacts["distance"][here], -x / np.float32(1024))
        np.testing.assert_array_equal(contacts["force"][here], np.float32(2.5) + x)
        friction = np.stack([np.zeros_like(x), np.full_like(x, 0.25), -x], 1)
        np.testing.assert_array_equal(contacts["friction"][here], friction)

        here, k = rows(events, frame), np.arange(frame % 7)
        np.testing.assert_array_equal(events["kind"][here], k % 5)
        np.testing.assert_array_equal(events["impulse"][here], np.where(k % 5 == 4, 4.75 + frame, 0))
        np.testing.assert_array_equal(events["a"][here], 2 * k + 1)
        np.testing.assert_array_equal(events["b"][here], np.full(len(k), 2 * frame + 1))

        value = (ids + 3 * frame) / 16
        there = (frame > 0) | (np.arange(bodies) % 5 != 4)
        np.testing.assert_array_equal(dataset["heat"][frame].values, np.where(there, value, np.nan).astype("f4"))
        np.testing.assert_array_equal(dataset["work"][frame].values, np.where(there, value / 3, np.nan))
        np.testing.assert_array_equal(run["touched"][frame], np.where(there, ids ^ frame, 0))
    print(f"{frames} frames of {bodies} bodies are equal")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
