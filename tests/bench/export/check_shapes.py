"""Reads what export_shapes wrote with readers of other projects.

Counts, places, areas and volumes are compared with the truth next to each file.

    python3 check_shapes.py FOLDER          FOLDER holds numbers.json

Needs numpy, trimesh, pygltflib, plyfile, midvoxio (PyPI), and vdb_print (Debian: libopenvdb-tools).
Exits with 1 when anything differs.
"""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pygltflib
import trimesh
from midvoxio.voxio import get_vox
from plyfile import PlyData

failures = 0


def check(what, found, wanted, tolerance=0):
    global failures
    same = abs(found - wanted) <= tolerance * abs(wanted) if tolerance else found == wanted
    failures += not same
    print(f"{'ok  ' if same else 'FAIL'} {what}: {found}" + ("" if same else f"; wanted {wanted}"))


def check_vox(file, truth):
    vox = get_vox(str(file))
    child_of = {t.node_id: t for t in vox.ntrns}
    middle_of_shape = {}
    for node in vox.ngrps[0].children_ids:
        transform = child_of[node]
        middle_of_shape[transform.child_node_id] = [
            int(v) for v in transform.frames[0]["_t"].split()
        ]
    places = []
    for shape in vox.nshps:
        model = shape.models[0].id
        size = np.array(vox.sizes[model])
        voxels = np.array(vox.voxels[model], dtype=np.int64)
        assert (voxels[:, :3] < size).all() and voxels[:, 3].min() >= 1
        places.append(voxels[:, :3] - size // 2 + np.array(middle_of_shape[shape.node_id]))
    places = np.concatenate(places)
    check(f"{file.name}: voxels", len(places), truth["seen"])
    check(f"{file.name}: places", len(np.unique(places, axis=0)), truth["seen"])
    return places


def check_vdb(file, truth):
    text = subprocess.run(
        ["vdb_print", "-l", file], capture_output=True, text=True, check=True
    ).stdout
    counts = {}
    for grid in text.split("\nName: ")[1:]:
        counts[grid.split("\n")[0]] = int(
            re.search(r"Number of active voxels:\s+([\d,]+)", grid).group(1).replace(",", "")
        )
    check(f"{file.name}: density", counts["density"], truth["solid"])
    check(f"{file.name}: material", counts["material"], truth["solid"])
    check(f"{file.name}: Cd", counts["Cd"], truth["seen"])


def is_closed(corners, quads):
    """@return whether each edge is traversed as often one way as the other; corners are merged"""
    _, same = np.unique(np.round(corners * 1024).astype(np.int64), axis=0, return_inverse=True)
    q = same.reshape(-1)[quads]
    ways = np.concatenate([q[:, [i, (i + 1) % 4]] for i in range(4)])
    forth = np.unique(ways, axis=0, return_counts=True)
    back = np.unique(ways[:, ::-1], axis=0, return_counts=True)
    return np.array_equal(forth[0], back[0]) and np.array_equal(forth[1], back[1])


def check_ply(file, truth, voxel_m, closed, single):
    ply = PlyData.read(str(file))
    v = ply["vertex"]
    corners = np.stack([v["x"], v["y"], v["z"]], axis=1).astype(np.float64)
    quads = np.stack(ply["face"]["vertex_indices"])
    a = corners[quads[:, 1]] - corners[quads[:, 0]]
    b = corners[quads[:, 3]] - corners[quads[:, 0]]
    normal = np.cross(a, b)
    check(f"{file.name}: area in faces", np.abs(normal).sum() / voxel_m**2, truth["faces"], 1e-9)
    if single:
        check(f"{file.name}: faces", len(quads), truth["faces"])
    if closed:
        volume = (corners[quads[:, 0]] * normal).sum() / 3 / voxel_m**3
        check(f"{file.name}: volume in voxels", volume, truth["solid"], 1e-9)
        if single:
            check(f"{file.name}: closed", bool(is_closed(corners, quads)), True)
    return {tuple(c) for c in np.stack([v["red"], v["green"], v["blue"]], axis=1)}


def srgb(linear):
    c = np.where(linear <= 0.0031308, linear * 12.92, 1.055 * np.power(linear, 1 / 2.4) - 0.055)
    return np.round(c * 255).astype(np.uint8)


def check_glb(file, truth, voxel_m, closed):
    head = pygltflib.GLTF2().load(str(file))
    triangles = sum(head.accessors[p.indices].count for p in head.meshes[0].primitives) // 3
    modes = {m.name: m.alphaMode for m in head.materials}
    scene = trimesh.load(str(file), process=False)
    meshes = list(scene.geometry.values())
    check(f"{file.name}: triangles of two readers", sum(len(m.faces) for m in meshes), triangles)
    check(
        f"{file.name}: area in faces",
        sum(m.area for m in meshes) / voxel_m**2,
        truth["faces"],
        1e-6,
    )
    if closed:
        check(
            f"{file.name}: volume in voxels",
            sum(m.volume for m in meshes) / voxel_m**3,
            truth["solid"],
            1e-6,
        )
    for name in ("water", "glass"):
        if name in modes:
            check(f"{file.name}: {name}", modes[name], "BLEND")
    colours = set()
    blob = head.binary_blob()
    for p in head.meshes[0].primitives:
        accessor = head.accessors[p.attributes.COLOR_0]
        view = head.bufferViews[accessor.bufferView]
        raw = np.frombuffer(
            blob, np.uint8, accessor.count * view.byteStride, view.byteOffset
        ).reshape(accessor.count, view.byteStride)
        linear = raw[:, 12:18].copy().view(np.uint16) / 65535
        colours |= {tuple(c) for c in srgb(linear)}
    return colours


def main():
    folder = Path(sys.argv[1])
    numbers = json.loads((folder / "numbers.json").read_text())
    for name, of in numbers.items():
        truth = of["truth"]
        voxel_m = of["voxel_m"]
        closed = name != "clear"
        check_vox(folder / f"{name}.vox", truth)
        check_vdb(folder / f"{name}.vdb", truth)
        of_ply = check_ply(folder / f"{name}.ply", truth, voxel_m, closed, False)
        check_ply(folder / f"{name}_single.ply", truth, voxel_m, closed, True)
        of_glb = check_glb(folder / f"{name}.glb", truth, voxel_m, closed)
        check_glb(folder / f"{name}_steps.glb", truth, voxel_m, closed)
        check_glb(folder / f"{name}_materials.glb", truth, voxel_m, closed)
        check(f"{name}: colours of .glb and .ply alike", of_glb == of_ply, True)
        if name == "ball":
            ball = trimesh.load(str(folder / "ball_single.ply"))
            ball.merge_vertices(merge_tex=True, merge_norm=True)
            check("ball: watertight, by trimesh", bool(ball.is_watertight), True)
            check("ball: volume, by trimesh", ball.volume / voxel_m**3, truth["solid"], 1e-6)
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
