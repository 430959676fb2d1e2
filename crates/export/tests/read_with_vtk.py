"""Opens a ParaView export with VTK and compares it with the trajectory, which Python's zarr reads.

Usage: read_with_vtk.py RUN EXPORT
"""

import functools
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import zarr
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkStringOutputWindow, vtkOutputWindow
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

# What VTK has to say of a file goes here instead of into a window.
messages = vtkStringOutputWindow()
vtkOutputWindow.SetInstance(messages)


def read(path: Path):
    reader = vtkXMLPolyDataReader()
    assert reader.CanReadFile(str(path)), path
    reader.SetFileName(str(path))
    reader.Update()
    assert messages.GetOutput() == "", messages.GetOutput()
    return reader.GetOutput()


glyph = functools.cache(read)


def arrays(data) -> dict[str, np.ndarray]:
    return {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}


def turn(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Rotates vectors by quaternions x, y, z, w in double precision."""
    q, v = q.astype(float), v.astype(float)
    u, w = q[..., :3], q[..., 3:]
    return v + 2 * np.cross(u, np.cross(u, v) + w * v)


def velocity(run, frame: int) -> np.ndarray:
    """The difference to the frame before, or to the one after where a body has just come."""
    p, t = run["position"], run["time"]
    none = np.full(p.shape[1:], np.nan, "f4")
    before = (p[frame] - p[frame - 1]) / (t[frame] - t[frame - 1]) if frame > 0 else none
    after = (p[frame + 1] - p[frame]) / (t[frame + 1] - t[frame]) if frame + 1 < len(t) else none
    return np.nan_to_num(np.where(np.isnan(before), after, before))


def triangles(data) -> np.ndarray:
    cells = data.GetPolys()
    offsets = vtk_to_numpy(cells.GetOffsetsArray())
    assert np.array_equal(offsets, 3 * np.arange(data.GetNumberOfPolys() + 1))
    return vtk_to_numpy(cells.GetConnectivityArray()).reshape(-1, 3)


def compare_points(run, origin, frame: int, data, moving: np.ndarray, export: Path) -> None:
    rows = np.flatnonzero(~np.isnan(run["position"][frame, :, 0]) & moving)
    found = arrays(data.GetPointData())
    assert data.GetNumberOfPoints() == data.GetNumberOfVerts() == len(rows) > 0
    np.testing.assert_array_equal(vtk_to_numpy(data.GetVerts().GetConnectivityArray()), np.arange(len(rows)))
    position = run["position"][frame][rows]
    place = vtk_to_numpy(data.GetPoints().GetData())
    np.testing.assert_array_equal(place, origin + position)
    assert place.dtype == ("f8" if origin.any() else "f4")
    for name, store in [("id", "id"), ("shape", "shape"), ("scale", "scale")]:
        np.testing.assert_array_equal(found[name], run[store][rows], err_msg=name)
    np.testing.assert_array_equal(found["orientation"], run["orientation"][frame][rows][:, [3, 0, 1, 2]])
    if "velocity" in run:
        # Stored ones are of the centre of mass, found ones of the origin of the shape: as far apart as the body turns at most.
        apart = np.linalg.norm(found["velocity"] - run["velocity"][frame][rows], axis=1)
        spin = run["angular_velocity"][frame][rows]
        assert (apart <= 0.5 * np.linalg.norm(spin, axis=1) + 1e-5).all() and (apart < 1e-6).any()
        np.testing.assert_array_equal(found["angular_velocity"], spin)
        np.testing.assert_array_equal(found["contact_count"], run["contact_count"][frame][rows])
        np.testing.assert_array_equal(found["run_size"], run["size"][frame][rows])
    else:
        np.testing.assert_allclose(found["velocity"], velocity(run, frame)[rows], rtol=2e-6, atol=1e-6)
    np.testing.assert_allclose(found["speed"], np.linalg.norm(found["velocity"], axis=1), rtol=1e-6)
    assert np.isfinite(found["angular_velocity"]).all()
    assert set(np.unique(found["material"])) <= {0, 1, 2}
    for shape in np.unique(found["shape"]):
        # A shape as a glyph has the size that its bodies say.
        bounds = np.array(glyph(export / f"shape-{shape}.vtp").GetBounds()).reshape(3, 2)
        size = found["size"][found["shape"] == shape]
        np.testing.assert_allclose(size, np.tile(bounds[:, 1] - bounds[:, 0], (len(size), 1)), rtol=0.04)


def compare_triangles(run, origin, frame: int, data, moving: np.ndarray, shapes) -> None:
    rows = np.flatnonzero(~np.isnan(run["position"][frame, :, 0]) & moving)
    found = arrays(data.GetCellData())
    corners = vtk_to_numpy(data.GetPoints().GetData())
    normals = vtk_to_numpy(data.GetPointData().GetNormals())
    cells = triangles(data)
    # Bodies follow each other, in the order of ids.
    ids, first = np.unique(found["id"], return_index=True)
    np.testing.assert_array_equal(ids, run["id"][rows])
    assert (np.diff(first) > 0).all()
    first = np.append(first, len(cells))
    velocities, point = velocity(run, frame), 0
    for row, start, end in zip(rows, first, first[1:]):
        shape = run["shape"][row]
        assert (found["id"][start:end] == run["id"][row]).all() and (found["shape"][start:end] == shape).all()
        local, local_cells, local_normals = shapes[shape]
        np.testing.assert_array_equal(cells[start:end] - point, local_cells)
        q = run["orientation"][frame, row]
        place = origin + run["position"][frame, row].astype(float) + turn(q, local)
        np.testing.assert_allclose(corners[point : point + len(local)], place, rtol=3e-7, atol=1e-6)
        np.testing.assert_allclose(normals[point : point + len(local)], turn(q, local_normals), atol=1e-6)
        np.testing.assert_allclose(found["velocity"][start:end], np.tile(velocities[row], (end - start, 1)), rtol=2e-6, atol=1e-6)
        point += len(local)
    assert point == len(corners)


def main(run_path: Path, export: Path) -> None:
    group = zarr.open_group(run_path / "trajectory.zarr", mode="r")
    run, origin = {name: group[name][:] for name in group.array_keys()}, np.array(group.attrs["origin"])
    frames, bodies = len(run["time"]), len(run["id"])

    static = read(export / "static.vtp")
    fixed = np.unique(arrays(static.GetCellData())["id"])
    assert list(fixed) == [1, 2, 3] and static.GetNumberOfPolys() > 100
    # The floor is seen as far as the bodies go.
    bounds = np.array(static.GetBounds()).reshape(3, 2) - origin[:, None]
    assert bounds[0, 0] < -5 and bounds[0, 1] > 5
    moving = ~np.isin(run["id"], fixed)

    listed = ElementTree.parse(export / "bodies.pvd").getroot().findall("Collection/DataSet")
    assert [float(entry.get("timestep")) for entry in listed] == list(run["time"])
    files = [export / entry.get("file") for entry in listed]
    assert {file.name for file in export.glob("frame-*")} == {file.name for file in files}

    for frame, file in enumerate(files):
        data = read(file)
        assert data.GetFieldData().GetArray("TimeValue").GetValue(0) == run["time"][frame]
        if data.GetNumberOfPolys() == 0:
            compare_points(run, origin, frame, data, moving, export)
        else:
            if frame == 0:
                shapes = body_frames(run, origin, files)
            compare_triangles(run, origin, frame, data, moving, shapes)
    print(f"{frames} frames of {bodies} bodies are equal")


def body_frames(run, origin, files):
    """The corners, triangles and normals of each shape in its own frame, taken from the first body and frame that has it."""
    shapes = {}
    for frame, file in enumerate(files):
        data = read(file)
        ids = arrays(data.GetCellData())["id"]
        corners, cells = vtk_to_numpy(data.GetPoints().GetData()), triangles(data)
        normals = vtk_to_numpy(data.GetPointData().GetNormals())
        for body in np.unique(ids):
            row = np.searchsorted(run["id"], body)
            if (shape := run["shape"][row]) in shapes:
                continue
            mine = cells[ids == body]
            low, high = mine.min(), mine.max() + 1
            back = run["orientation"][frame, row] * [-1, -1, -1, 1]
            local = turn(back, corners[low:high] - origin - run["position"][frame, row])
            shapes[shape] = (local, mine - low, turn(back, normals[low:high]))
    return shapes


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
