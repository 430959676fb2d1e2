"""Opens a Parquet export with pyarrow and compares it with the trajectory, which Python's zarr reads.

Usage: read_with_pyarrow.py RUN EXPORT    (a file, or a folder with one for each frame)
       read_with_pyarrow.py ids EXPORT    prints the ids
"""

import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute
import pyarrow.parquet as pq
import zarr


def columns(table: pa.Table, names: str) -> np.ndarray:
    return np.stack([table[name].to_numpy() for name in names.split()], axis=1)


def velocity(values: np.ndarray, time: np.ndarray, frame: int) -> np.ndarray:
    none = np.full(values.shape[1:], np.nan, "f4")
    before = (values[frame] - values[frame - 1]) / (time[frame] - time[frame - 1]) if frame > 0 else none
    after = (values[frame + 1] - values[frame]) / (time[frame + 1] - time[frame]) if frame + 1 < len(time) else none
    return np.nan_to_num(np.where(np.isnan(before), after, before))


def main(run_path: Path, export: Path) -> None:
    group = zarr.open_group(run_path / "trajectory.zarr", mode="r")
    run, origin = {name: group[name][:] for name in group.array_keys()}, np.array(group.attrs["origin"])
    time, position = run["time"], run["position"]
    if export.is_dir():
        files = sorted(export.iterdir())
        assert [file.name for file in files] == [f"frame-{frame:06}.parquet" for frame in range(len(time))]
        tables = [pq.read_table(file) for file in files]
        whole, layout = pa.concat_tables(tables), "one file for each frame"
    else:
        whole = pq.read_table(export)
        layout = f"in {pq.ParquetFile(export).num_row_groups} row groups"
    place = pa.float64() if origin.any() else pa.float32()
    kinds = {"frame": pa.int32(), "time_s": pa.float64(), "id": pa.uint64(), "name": pa.string(), "shape": pa.uint32()}
    for field in whole.schema:
        kind = place if field.name in ("x_m", "y_m", "z_m") else kinds.get(field.name, pa.float32())
        assert field.type == kind and not field.nullable, field

    count = 0
    for frame in range(len(time)):
        table = whole.filter(pa.compute.equal(whole["frame"], frame))
        rows = np.flatnonzero(~np.isnan(position[frame, :, 0]))
        np.testing.assert_array_equal(table["time_s"], np.full(len(rows), time[frame]))
        for name, store in [("id", "id"), ("name", "name"), ("shape", "shape"), ("scale", "scale")]:
            np.testing.assert_array_equal(table[name].to_numpy(), run[store][rows], err_msg=name)
        np.testing.assert_array_equal(columns(table, "x_m y_m z_m"), origin + position[frame][rows])
        np.testing.assert_array_equal(columns(table, "qx qy qz qw"), run["orientation"][frame][rows])
        expected = velocity(position, time, frame)[rows]
        np.testing.assert_allclose(columns(table, "vx_m_s vy_m_s vz_m_s"), expected, rtol=2e-6, atol=1e-6)
        assert np.isfinite(columns(table, "wx_rad_s wy_rad_s wz_rad_s")).all()
        count += len(rows)
    assert count == len(whole)
    print(f"{count} rows are equal, {layout}")


if __name__ == "__main__":
    if sys.argv[1] == "ids":
        print(pq.read_table(sys.argv[2])["id"].to_pylist())
    else:
        main(Path(sys.argv[1]), Path(sys.argv[2]))
