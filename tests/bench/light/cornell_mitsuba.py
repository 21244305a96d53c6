"""Mitsuba 3 on a box of voxels: the reference of the entries light/cornell.

    python3 cornell_mitsuba.py JOB.json        (any Python with the packages mitsuba and numpy)

The job names everything, so that both renderers get the same numbers. Vectors are x, y, z
(right-handed, y up), light is linear r, g, b:

  parts     [{quads, albedo, emission}]: quads is a file of raw float32, the four corners of each
            in order, anticlockwise from outside
  camera    {position, target, fov_deg: vertical};  size_px, samples, threads, seed
  sky       radiance, the same all around
  sun       null, or {to, light: radiance of a white surface that faces it, radius_rad}
  picture   file that takes raw float32 r, g, b, rows from the top
  figures   file that takes the figures: {mitsuba, wall_s}

Pixels are boxes, paths end by Russian roulette alone.
"""

import json
import math
import sys
import time
from pathlib import Path

import mitsuba as mi
import numpy as np

SUN_DISTANCE = 1e5  # voxels: far enough for parallel light in a box of some dozens


def mesh_of(part, number, folder):
    corners = np.fromfile(part["quads"], np.float32).reshape(-1, 3)
    quads = np.arange(len(corners), dtype=np.int32).reshape(-1, 4)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    file = Path(folder) / f"part-{number}.ply"
    faces = np.empty(len(triangles), np.dtype([("count", "u1"), ("corners", "<i4", 3)]))
    faces["count"] = 3
    faces["corners"] = triangles
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(corners)}\n"
        "property float x\nproperty float y\nproperty float z\n"
    )
    header += f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    file.write_bytes(header.encode() + corners.astype("<f4").tobytes() + faces.tobytes())
    shape = {
        "type": "ply",
        "filename": str(file),
        "face_normals": True,
        "bsdf": {"type": "diffuse", "reflectance": rgb(part["albedo"])},
    }
    if any(part["emission"]):
        shape["emitter"] = {"type": "area", "radiance": rgb(part["emission"])}
    return shape


def rgb(values):
    return {"type": "rgb", "value": [float(v) for v in values]}


def sun_disc(sun):
    radius = SUN_DISTANCE * math.tan(sun["radius_rad"])
    scale = 1 / math.sin(sun["radius_rad"]) ** 2
    to = np.array(sun["to"]) / np.linalg.norm(sun["to"])
    place = mi.ScalarTransform4f().look_at(
        origin=list(to * SUN_DISTANCE), target=[0, 0, 0], up=[0, 0, 1]
    )
    return {
        "type": "disk",
        "to_world": place @ mi.ScalarTransform4f().scale(radius),
        "bsdf": {"type": "diffuse", "reflectance": rgb([0, 0, 0])},
        "emitter": {"type": "area", "radiance": rgb([v * scale for v in sun["light"]])},
    }


def scene_of(job, folder):
    camera = job["camera"]
    width, height = job["size_px"]
    scene = {"type": "scene", "integrator": {"type": "path", "max_depth": -1, "rr_depth": 8}}
    scene["sensor"] = {
        "type": "perspective",
        "fov": camera["fov_deg"],
        "fov_axis": "y",
        "near_clip": 0.01,
        "far_clip": 1e6,
        "to_world": mi.ScalarTransform4f().look_at(
            origin=camera["position"], target=camera["target"], up=[0, 1, 0]
        ),
        "sampler": {"type": "independent", "sample_count": job["samples"]},
        "film": {
            "type": "hdrfilm",
            "width": width,
            "height": height,
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
            "component_format": "float32",
        },
    }
    for number, part in enumerate(job["parts"]):
        scene[f"part{number}"] = mesh_of(part, number, folder)
    if any(job["sky"]):
        scene["sky"] = {"type": "constant", "radiance": rgb(job["sky"])}
    if job["sun"]:
        scene["sun"] = sun_disc(job["sun"])
    return scene


def main():
    job = json.loads(Path(sys.argv[1]).read_text())
    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Warn)
    scene = mi.load_dict(scene_of(job, Path(job["picture"]).parent))
    start = time.perf_counter()
    image = np.array(mi.render(scene, seed=job["seed"]), np.float32)
    figures = {"mitsuba": mi.__version__, "wall_s": time.perf_counter() - start}
    image[:, :, :3].tofile(job["picture"])
    Path(job["figures"]).write_text(json.dumps(figures))


main()
