"""Compares a CSV with the trajectory, which Python's zarr reads.

Usage: read_csv.py RUN CSV FIRST LAST IDS    (IDS is `all`, or ranges such as 2-4,10-20)
"""

import csv
import sys
from pathlib import Path

import numpy as np
import zarr


def main(run_path: Path, file: Path, first: int, last: int, ids: str) -> None:
    run = zarr.open_group(run_path / "trajectory.zarr", mode="r")
    origin = np.array(run.attrs["origin"])
    all_ids, names, time = run["id"][:], run["name"][:], run["time"][:]
    chosen = np.ones(len(all_ids), bool)
    if ids != "all":
        ranges = [map(int, part.split("-")) for part in ids.split(",")]
        chosen = np.any([(all_ids >= low) & (all_ids <= high) for low, high in ranges], axis=0)

    with file.open(newline="", encoding="utf-8") as text:
        rows = iter(csv.DictReader(text, strict=True))
        count = 0
        for frame in range(first, last + 1):
            position, rotation = run["position"][frame], run["orientation"][frame]
            for body in np.flatnonzero(chosen & ~np.isnan(position[:, 0])):
                row = next(rows)
                assert (int(row["frame"]), float(row["time_s"])) == (frame, time[frame])
                assert (int(row["id"]), row["name"]) == (all_ids[body], names[body])
                assert [np.float64(row[c]) for c in ("x_m", "y_m", "z_m")] == list(origin + position[body].astype(float))
                assert [np.float32(row[c]) for c in ("qx", "qy", "qz", "qw")] == list(rotation[body])
                if frame > 0 and not np.isnan(run["position"][frame - 1, body, 0]):
                    mean = (position[body] - run["position"][frame - 1, body]) / (time[frame] - time[frame - 1])
                    found = [float(row[c]) for c in ("vx_m_s", "vy_m_s", "vz_m_s")]
                    np.testing.assert_allclose(found, mean, rtol=2e-6, atol=1e-6)
                if names[body].startswith("wiper"):
                    turning = [float(row[c]) for c in ("wx_rad_s", "wy_rad_s", "wz_rad_s")]
                    np.testing.assert_allclose(turning, [0, 0, 3], atol=1e-3)
                count += 1
        assert next(rows, None) is None
    print(f"{count} rows are equal")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]), sys.argv[5])
