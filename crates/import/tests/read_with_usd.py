"""Writes a stage as usdc and usdz, and says where OpenUSD has its bodies.

    read_with_usd.py STAGE FOLDER

A line for each body that collides: its prim, and how far it reaches along each of 26 directions of the world, in metres and with z up (JSON). What a
collider is comes from the schemas of UsdGeom; where it is, from UsdGeom.XformCache and UsdGeom.PointInstancer.
"""

import itertools
import json
import shutil
import sys
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom, UsdPhysics, UsdUtils, Sdf

stage_path, folder = Path(sys.argv[1]), Path(sys.argv[2])
stage = Usd.Stage.Open(str(stage_path))
for ending in ("usdc", "usd"):
    stage.GetRootLayer().Export(str(folder / f"stage.{ending}"))
for layer in stage.GetUsedLayers():
    if layer.realPath and layer != stage.GetRootLayer():
        shutil.copy(layer.realPath, folder)
assert UsdUtils.CreateNewUsdzPackage(Sdf.AssetPath(str(folder / "stage.usdc")), str(folder / "stage.usdz"))

metre = UsdGeom.GetStageMetersPerUnit(stage)
turn = np.eye(3)
if UsdGeom.GetStageUpAxis(stage) == "Y":
    turn = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]], dtype=float)
# Where there is no default but samples, the first of them.
time = Usd.TimeCode(stage.GetStartTimeCode()) if stage.HasAuthoredTimeCodeRange() else Usd.TimeCode.Default()
cache = UsdGeom.XformCache(time)
directions = [np.array(d, dtype=float) for d in itertools.product((-1, 0, 1), repeat=3) if any(d)]
directions = [d / np.linalg.norm(d) for d in directions]


def axis(prim):
    return "XYZ".index(prim.GetAttribute("axis").Get())


def reach(prim, e):
    """How far a collider reaches along `e` in its own frame."""
    get = lambda name: prim.GetAttribute(name).Get()
    kind = prim.GetTypeName()
    if kind == "Cube":
        return 0.5 * get("size") * np.abs(e).sum()
    if kind == "Sphere":
        return get("radius") * np.linalg.norm(e)
    if kind == "Mesh":
        points = np.array(get("points"), dtype=float)
        if get("physics:approximation") == "boundingCube":
            low, high = points.min(axis=0), points.max(axis=0)
            return np.where(e > 0, high, low) @ e
        return (points @ e).max()
    along, half = e[axis(prim)], 0.5 * get("height")
    across = np.sqrt(max(e @ e - along * along, 0.0))
    if kind == "Capsule":
        return half * abs(along) + get("radius") * np.linalg.norm(e)
    if kind == "Cylinder":
        return half * abs(along) + get("radius") * across
    if kind == "Cone":
        return max(half * along, -half * along + get("radius") * across)
    raise AssertionError(kind)


def is_collider(prim):
    return prim.HasAPI(UsdPhysics.CollisionAPI) and UsdPhysics.CollisionAPI(prim).GetCollisionEnabledAttr().Get()


def is_body(prim):
    return prim.HasAPI(UsdPhysics.RigidBodyAPI) and UsdPhysics.RigidBodyAPI(prim).GetRigidBodyEnabledAttr().Get()


def colliders(root):
    """Colliders below a prim, by the body that they belong to, or by themselves."""
    found = {}
    tree = iter(Usd.PrimRange(root, Usd.TraverseInstanceProxies(Usd.PrimIsActive & Usd.PrimIsLoaded)))
    for prim in tree:
        if prim != root and prim.IsA(UsdGeom.PointInstancer):
            tree.PruneChildren()
            continue
        if not is_collider(prim) or prim.GetTypeName() == "Plane":
            continue
        owner = prim
        while owner and not is_body(owner):
            owner = owner.GetParent()
        found.setdefault(str((owner or prim).GetPath()), []).append(prim)
    return found


def say(name, placed):
    """`placed` has colliders and their matrices to the world of the stage, for row vectors."""
    best = []
    for d in directions:
        most = -np.inf
        for prim, matrix in placed:
            m = np.array(matrix)
            linear, origin = turn @ m[:3, :3].T * metre, turn @ m[3, :3] * metre
            most = max(most, d @ origin + reach(prim, linear.T @ d))
        best.append(most)
    print(json.dumps([name, best]))


for root in stage.GetPseudoRoot().GetChildren():
    if root.IsAbstract():
        continue
    for name, prims in colliders(root).items():
        say(name, [(prim, cache.GetLocalToWorldTransform(prim)) for prim in prims])

for prim in stage.Traverse():
    if not prim.IsA(UsdGeom.PointInstancer):
        continue
    instancer = UsdGeom.PointInstancer(prim)
    places = instancer.ComputeInstanceTransformsAtTime(time, time, UsdGeom.PointInstancer.IncludeProtoXform)
    # Masked by what is invisible and inactive.
    mask = instancer.ComputeMaskAtTime(time)
    which = instancer.GetProtoIndicesAttr().Get()
    ids = instancer.GetIdsAttr().Get() or list(range(len(which)))
    targets = instancer.GetPrototypesRel().GetTargets()
    places = [p for p, keep in zip(places, mask)] if mask and len(places) == len(which) else places
    kept = [i for i in range(len(which)) if not mask or mask[i]]
    if len(places) != len(kept):
        places = [places[i] for i in kept]
    for i, place in zip(kept, places):
        proto = stage.GetPrimAtPath(targets[which[i]])
        for name, prims in colliders(proto).items():
            inner = lambda p: cache.GetLocalToWorldTransform(p) * cache.GetLocalToWorldTransform(proto).GetInverse()
            world = cache.GetLocalToWorldTransform(prim)
            placed = [(p, inner(p) * place * world) for p in prims]
            say(f"{prim.GetPath()}[{ids[i]}]{name[len(str(proto.GetPath())):]}", placed)
