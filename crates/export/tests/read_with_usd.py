"""Opens a USD export with OpenUSD and compares it with the trajectory, which Python's zarr reads.

Usage: read_with_usd.py RUN FILE FRAMES [velocities] [precise]

FILE is the one to open, FRAMES are the numbers that were exported, with commas between. Bodies with ids from 6000 on are static, and all but two of them are instances.
"""

import sys
from pathlib import Path

import numpy as np
import zarr
from pxr import Gf, Usd, UsdGeom, UsdShade, UsdValidation

STATIC = {1: "Body_1", 2: "Body_2", 3: "post"}
# The second has a shape that no other has, the fourth a name, and the one that the instances have.
SINGLE = {6001: "Body_6001", 6003: "Instances_2"}
CROWD = 6000


def quaternions(values) -> np.ndarray:
    return np.array([[*q.imaginary, q.real] for q in values], "f4").reshape(-1, 4)


def matrices(positions: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Rows for vectors that stand before them, in double precision."""
    x, y, z, w = np.moveaxis(turns.astype(float), -1, 0)
    out = np.zeros((len(positions), 4, 4))
    out[:, 0, :3] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], -1)
    out[:, 1, :3] = np.stack([2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)], -1)
    out[:, 2, :3] = np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], -1)
    out[:, 3, :3], out[:, 3, 3] = positions, 1
    return out


def validate(stage: Usd.Stage) -> None:
    """All of OpenUSD's own validators."""
    registry = UsdValidation.ValidationRegistry()
    validators = registry.GetOrLoadAllValidators()
    assert len(validators) > 20
    errors = UsdValidation.ValidationContext(validators).Validate(stage)
    assert not errors, [(error.GetName(), error.GetMessage()) for error in errors]


def check_static(stage: Usd.Stage, run, origin: np.ndarray, frame: int) -> None:
    scope = stage.GetPrimAtPath("/World/Static")
    ids = run["id"][:]
    crowd = bool((ids >= CROWD).any())
    meshes = STATIC | (SINGLE if crowd else {})
    assert [child.GetName() for child in scope.GetChildren()] == ["Instances"] * crowd + list(meshes.values())
    if crowd:
        check_instances(stage, run, np.flatnonzero((ids >= CROWD) & ~np.isin(ids, list(SINGLE))), frame)
    for id, name in meshes.items():
        mesh = UsdGeom.Mesh(scope.GetChild(name))
        check_mesh(mesh)
        row = list(run["id"][:]).index(id)
        found = np.array(UsdGeom.Xformable(mesh).ComputeLocalToWorldTransform(Usd.TimeCode.Default()))
        want = matrices(origin + run["position"][frame, row : row + 1], run["orientation"][frame, row : row + 1])
        # OpenUSD goes through the angle of a rotation, which the arc cosine of a number near 1 tells less well.
        np.testing.assert_allclose(found, want[0], atol=3e-6 if id in SINGLE else 1e-6)


def check_instances(stage: Usd.Stage, run, rows: np.ndarray, frame: int) -> None:
    instances = UsdGeom.PointInstancer(stage.GetPrimAtPath("/World/Static/Instances"))
    ids = np.array(instances.GetIdsAttr().Get())
    order = np.argsort(ids)
    np.testing.assert_array_equal(ids[order], run["id"][:][rows])
    position, turn = run["position"][frame][rows], run["orientation"][frame][rows]
    np.testing.assert_array_equal(np.array(instances.GetPositionsAttr().Get())[order], position)
    np.testing.assert_array_equal(quaternions(instances.GetOrientationsfAttr().Get())[order], turn)
    half = quaternions(instances.GetOrientationsAttr().Get())[order]
    np.testing.assert_array_equal(half, turn.astype("f2").astype("f4"))
    prototypes = [stage.GetPrimAtPath(path) for path in instances.GetPrototypesRel().GetTargets()]
    assert len(prototypes) == 4
    for prim in prototypes:
        assert prim.GetParent().GetTypeName() == "Scope"
        check_mesh(UsdGeom.Mesh(prim))
    shapes = np.array([int(prototypes[k].GetName().split("_")[1]) for k in instances.GetProtoIndicesAttr().Get()])
    np.testing.assert_array_equal(shapes[order], run["shape"][:][rows])
    now = Usd.TimeCode.EarliestTime()
    found = np.array(instances.ComputeInstanceTransformsAtTime(now, now))
    np.testing.assert_allclose(found[order], matrices(position, turn), atol=2e-6)
    low, high = np.array(instances.GetExtentAttr().Get())
    for k, matrix in zip(instances.GetProtoIndicesAttr().Get(), found):
        points = np.array(UsdGeom.Mesh(prototypes[k]).GetPointsAttr().Get())
        corners = points @ matrix[:3, :3] + matrix[3, :3]
        assert (low <= corners.min(0)).all() and (corners.max(0) <= high).all()


def check_mesh(mesh: UsdGeom.Mesh) -> None:
    points, corners = mesh.GetPointsAttr().Get(), mesh.GetFaceVertexIndicesAttr().Get()
    counts = mesh.GetFaceVertexCountsAttr().Get()
    valid, why = UsdGeom.Mesh.ValidateTopology(corners, counts, len(points))
    assert valid, why
    assert set(counts) == {3}
    low, high = np.array(mesh.GetExtentAttr().Get())
    points = np.array(points)
    assert np.array_equal(points.min(0), low) and np.array_equal(points.max(0), high)
    normals = mesh.GetNormalsAttr().Get()
    if normals is not None:
        assert mesh.GetNormalsInterpolation() == "vertex" and len(normals) == len(points)
        np.testing.assert_allclose(np.linalg.norm(np.array(normals), axis=1), 1, atol=1e-5)
    material, _ = UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()
    shader, _, _ = material.ComputeSurfaceSource()
    assert shader.GetIdAttr().Get() == "UsdPreviewSurface"
    assert list(mesh.GetDisplayColorAttr().Get()) == [shader.GetInput("diffuseColor").Get()]


def main(run_path: Path, file: str, frames: list[int], options: set[str]) -> None:
    run = zarr.open_group(run_path / "trajectory.zarr", mode="r")
    origin = np.array(run.attrs["origin"])
    ids = run["id"][:].astype("i8")
    moving = np.flatnonzero(~np.isin(ids, list(STATIC)) & (ids < CROWD))

    stage = Usd.Stage.Open(file)
    validate(stage)
    assert stage.GetDefaultPrim().GetPath() == "/World"
    assert UsdGeom.GetStageUpAxis(stage) == "Z" and UsdGeom.GetStageMetersPerUnit(stage) == 1
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (frames[0], frames[-1])
    assert stage.GetTimeCodesPerSecond() == stage.GetFramesPerSecond() == 60
    check_static(stage, run, origin, frames[0])

    bodies = UsdGeom.PointInstancer(stage.GetPrimAtPath("/World/Bodies"))
    assert list(bodies.GetIdsAttr().Get()) == list(ids[moving])
    prototypes = [stage.GetPrimAtPath(path) for path in bodies.GetPrototypesRel().GetTargets()]
    assert len({prim.GetPath() for prim in prototypes}) == len(prototypes)
    for prim in prototypes:
        assert prim.GetParent().GetTypeName() == "Scope"
        check_mesh(UsdGeom.Mesh(prim))
    shapes = [int(prototypes[k].GetName().split("_")[1]) for k in bodies.GetProtoIndicesAttr().Get()]
    assert shapes == list(run["shape"][:][moving])

    positions, turns = bodies.GetPositionsAttr(), bodies.GetOrientationsAttr()
    for attribute in (positions, turns, bodies.GetInvisibleIdsAttr(), bodies.GetExtentAttr()):
        assert attribute.GetTimeSamples() == frames, attribute
    optional = {"orientationsf": "precise", "velocities": "velocities", "angularVelocities": "velocities"}
    for name, option in optional.items():
        assert (bodies.GetPrim().GetAttribute(name).GetNumTimeSamples() > 0) == (option in options), name

    motion = run["position"][:], run["orientation"][:], run["time"][:]
    for k, frame in enumerate(frames):
        position, turn = run["position"][frame][moving], run["orientation"][frame][moving]
        there = ~np.isnan(position[:, 0])
        assert there.any()
        assert sorted(bodies.GetInvisibleIdsAttr().Get(frame)) == list(ids[moving][~there])
        found = np.array(positions.Get(frame))
        np.testing.assert_array_equal(found[there], position[there])
        assert np.isfinite(found).all()
        np.testing.assert_array_equal(quaternions(turns.Get(frame))[there], turn[there].astype("f2").astype("f4"))
        low, high = np.array(bodies.GetExtentAttr().Get(frame))
        assert (low < found[there]).all() and (found[there] < high).all()

        want = matrices(position[there], turn[there])
        xforms = np.array(bodies.ComputeInstanceTransformsAtTime(frame, frame, applyMask=UsdGeom.PointInstancer.ApplyMask))
        np.testing.assert_allclose(xforms, want, atol=2e-6 if "precise" in options else 2e-3)
        if "precise" in options:
            np.testing.assert_array_equal(quaternions(bodies.GetOrientationsfAttr().Get(frame))[there], turn[there])
        if "velocities" in options:
            check_motion(*motion, bodies, frame, moving, there)
        elif k + 1 < len(frames):
            # Between frames programs go straight from one to the next, also where two clips meet.
            after = run["position"][frames[k + 1]][moving]
            both = there & ~np.isnan(after[:, 0])
            between = np.array(positions.Get((frame + frames[k + 1]) / 2))
            np.testing.assert_allclose(between[both], ((position + after) / 2)[both], rtol=1e-5, atol=1e-6)
    print(f"{len(frames)} frames of {len(ids)} bodies are equal")


def check_motion(p, q, t, bodies, frame: int, moving: np.ndarray, there: np.ndarray) -> None:
    """The mean over the step before, or over the one after where a body has just come."""
    steps = [(f, f + 1) for f in (frame - 1, frame) if 0 <= f < len(t) - 1]
    velocities = np.array(bodies.GetVelocitiesAttr().Get(frame))
    spins = np.radians(np.array(bodies.GetAngularVelocitiesAttr().Get(frame)))
    for k in np.flatnonzero(there):
        row = moving[k]
        step = next(((a, b) for a, b in steps if not np.isnan(p[a, row, 0]) and not np.isnan(p[b, row, 0])), None)
        if step is None:
            assert not velocities[k].any() and not spins[k].any()
            continue
        a, b = step
        np.testing.assert_allclose(velocities[k], (p[b, row] - p[a, row]) / (t[b] - t[a]), rtol=1e-5, atol=2e-6)
        one, two = (Gf.Quatd(*map(float, q[f, row][[3, 0, 1, 2]])) for f in step)
        turn = two * one.GetInverse()
        # The short way round. An arc cosine would lose what is left of small angles.
        axis, real = np.array(turn.imaginary) * np.sign(turn.real), abs(turn.real)
        sine = np.linalg.norm(axis)
        want = axis * (2 * np.arctan2(sine, real) / max(sine, 1e-12)) / (t[b] - t[a])
        np.testing.assert_allclose(spins[k], want, rtol=1e-5, atol=2e-5)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], [int(n) for n in sys.argv[3].split(",")], set(sys.argv[4:]))
