"""Reads colours and visual meshes in exports with OpenUSD and by the letter of glTF, and compares them with what the scene says.

Usage: read_looks.py USD GLB OBJ    (OBJ is the mesh that body 5000 shows at 0.4 of its size)
"""

import sys
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom
from read_glb import Glb


def linear(color: str) -> np.ndarray:
    x = np.array([int(color[k : k + 2], 16) for k in (1, 3, 5)]) / 255
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def corners_of(path: Path) -> np.ndarray:
    lines = path.read_text().splitlines()
    return 0.4 * np.array([line.split()[1:4] for line in lines if line.startswith("v ")], "f4")


def compare(what: str, found, expected, atol: float = 1e-6) -> None:
    np.testing.assert_allclose(np.array(found, "f8"), expected, atol=atol, err_msg=what)


def usd(path: str, corners: np.ndarray) -> None:
    stage = Usd.Stage.Open(path)
    bodies = UsdGeom.PointInstancer(stage.GetPrimAtPath("/World/Bodies"))
    prototypes = [stage.GetPrimAtPath(path) for path in bodies.GetPrototypesRel().GetTargets()]
    row = list(bodies.GetIdsAttr().Get()).index(5000)
    hare = UsdGeom.Mesh(prototypes[bodies.GetProtoIndicesAttr().Get()[row]])
    compare("own colour", hare.GetDisplayColorAttr().Get()[0], linear("#ff8001"))
    points = np.array(hare.GetPointsAttr().Get())
    compare("visual", [points.min(0), points.max(0)], [corners.min(0), corners.max(0)])
    post = UsdGeom.Mesh(stage.GetPrimAtPath("/World/Static/post"))
    compare("colour of a material", post.GetDisplayColorAttr().Get()[0], linear("#30404C"))
    colors = {tuple(np.round(UsdGeom.Mesh(prim).GetDisplayColorAttr().Get()[0], 5)) for prim in prototypes}
    assert tuple(np.round(linear("#00ff80").astype("f4"), 5)) in colors, colors


def glb(path: Path, corners: np.ndarray) -> None:
    file = Glb(path)
    materials = [material["pbrMetallicRoughness"]["baseColorFactor"] for material in file.json["materials"]]
    looks = {}
    for node in file.json["nodes"][:-1]:
        ids = file.numbers(node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["_ID"])
        (primitive,) = file.json["meshes"][node["mesh"]]["primitives"]
        for id in ids:
            looks[int(id)] = primitive
    color = lambda id: materials[looks[id]["material"]]
    compare("own colour", color(5000), [*linear("#ff8001"), 1])
    compare("colour of a material", color(3), [*linear("#30404C"), 1])
    points = file.numbers(looks[5000]["attributes"]["POSITION"])
    compare("visual", [points.min(0), points.max(0)], [corners.min(0), corners.max(0)])
    assert any(np.allclose(material, [*linear("#00ff80"), 1], atol=1e-6) for material in materials)


if __name__ == "__main__":
    corners = corners_of(Path(sys.argv[3]))
    usd(sys.argv[1], corners)
    glb(Path(sys.argv[2]), corners)
    print("looks are those of the scene")
