"""Opens what the Rust tests wrote with OpenUSD itself and compares every value.

Usage: read_with_usd.py same FILE.usdc FILE.usda
       read_with_usd.py samples FILE.usdc EXPECTED

The first compares two layers, field by field. The second compares samples with raw little-endian arrays in the folder EXPECTED: time.f64, and of each
frame positions.f32 and turns.f16.
"""

import sys
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd


def same(binary: str, text: str) -> None:
    one, other = Sdf.Layer.OpenAsAnonymous(binary), Sdf.Layer.OpenAsAnonymous(text)
    assert one.GetFileFormat().formatId in ("usdc", "usd"), one.GetFileFormat().formatId
    fields = 0
    paths: dict[str, list[Sdf.Path]] = {}
    for layer, key in ((one, "one"), (other, "other")):
        found: list[Sdf.Path] = []
        layer.Traverse(Sdf.Path.absoluteRootPath, found.append)
        paths[key] = sorted(found)
    assert paths["one"] == paths["other"], set(paths["one"]) ^ set(paths["other"])
    for path in paths["one"]:
        if path.IsTargetPath():
            continue
        a, b = one.GetObjectAtPath(path) or one.pseudoRoot, other.GetObjectAtPath(path) or other.pseudoRoot
        assert type(a) is type(b), path
        # The text format says of each property that it is not custom; without a word that is so.
        keys = (set(a.ListInfoKeys()) | set(b.ListInfoKeys())) - {"custom"}
        for key in keys:
            assert a.HasInfo(key) and b.HasInfo(key), (path, key)
            assert repr(a.GetInfo(key)) == repr(b.GetInfo(key)), (path, key, a.GetInfo(key), b.GetInfo(key))
            fields += 1
    # Order of children and properties as well.
    assert one.ExportToString() == other.ExportToString()
    print(f"{len(paths['one'])} specs with {fields} fields are equal")


def samples(binary: str, expected: str) -> None:
    folder = Path(expected)
    times = np.fromfile(folder / "time.f64", "<f8")
    stage = Usd.Stage.Open(binary)
    prim = stage.GetPrimAtPath("/World/Points")
    positions, turns, ids = (prim.GetAttribute(name) for name in ("positions", "orientations", "ids"))
    assert positions.GetTimeSamples() == list(times) and turns.GetTimeSamples() == list(times)
    assert ids.GetNumTimeSamples() == 0
    values = 0
    for frame, time in enumerate(times):
        want = np.fromfile(folder / f"positions-{frame}.f32", "<f4").reshape(-1, 3)
        assert np.array_equal(np.array(positions.Get(time)), want), time
        want_turns = np.fromfile(folder / f"turns-{frame}.f16", "<f2").reshape(-1, 4)
        got = turns.Get(time)
        assert len(got) == len(want_turns)
        got = np.array([[*turn.imaginary, turn.real] for turn in got], "<f2").reshape(-1, 4)
        assert np.array_equal(got, want_turns), time
        values += want.size + want_turns.size
    assert list(ids.Get()) == list(range(1, len(want) + 1))
    print(f"{len(times)} frames with {values} numbers are equal")


if __name__ == "__main__":
    {"same": same, "samples": samples}[sys.argv[1]](*sys.argv[2:])
