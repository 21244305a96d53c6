"""Blender Cycles on a mesh of grey quads: pictures and times, for the entry light/cycles.

    blender -b -P cycles_render.py -- JOB.json

The job names everything, so that both renderers get the same numbers:

  mesh         raw float32, x, y, z of the four corners of each quad in order (right-handed, y up)
  albedo       of the quads
  sky          radiance, linear r, g, b
  sun          {to: [x, y, z], irradiance, radius_rad}
  bounces, samples, threads, seeds: [..], size_px: [width, height]
  views        [{name, position, target, fov_deg: vertical}]
  pictures     folder for NAME-SEED.f32: raw float32 r, g, b, rows from the top
  figures      file that takes the figures:
               {blender, build_s, views: {name: {seed: {wall_s, cpu_s}}}}

The scene stays in memory between pictures, and each view has a tiny picture first: times are those
of path tracing alone. Pixels are boxes on both sides, and no light is cut off, so that the means
are comparable.
"""

import json
import math
import sys
import time
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix, Vector


def add_mesh(path, albedo):
    corners = np.fromfile(path, np.float32)
    count = corners.size // 3
    mesh = bpy.data.meshes.new("voxels")
    mesh.vertices.add(count)
    mesh.vertices.foreach_set("co", corners)
    mesh.loops.add(count)
    mesh.loops.foreach_set("vertex_index", np.arange(count, dtype=np.int32))
    mesh.polygons.add(count // 4)
    mesh.polygons.foreach_set("loop_start", np.arange(0, count, 4, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(count // 4, 4, np.int32))
    mesh.update(calc_edges=True)
    grey = bpy.data.materials.new("grey")
    grey.use_nodes = True
    nodes = grey.node_tree.nodes
    nodes.clear()
    matt = nodes.new("ShaderNodeBsdfDiffuse")
    matt.inputs["Color"].default_value = (albedo, albedo, albedo, 1)
    matt.inputs["Roughness"].default_value = 0
    grey.node_tree.links.new(
        matt.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]
    )
    mesh.materials.append(grey)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("voxels", mesh))


def add_light(job):
    world = bpy.data.worlds.new("sky")
    bpy.context.scene.world = world
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (*job["sky"], 1)
    data = bpy.data.lights.new("sun", "SUN")
    data.energy = job["sun"]["irradiance"]
    data.angle = 2 * job["sun"]["radius_rad"]
    sun = bpy.data.objects.new("sun", data)
    sun.rotation_mode = "QUATERNION"
    sun.rotation_quaternion = Vector(job["sun"]["to"]).to_track_quat("Z", "Y")
    bpy.context.scene.collection.objects.link(sun)


def add_camera(view):
    data = bpy.data.cameras.new(view["name"])
    data.sensor_fit = "VERTICAL"
    data.angle = math.radians(view["fov_deg"])
    data.clip_end = 5000
    camera = bpy.data.objects.new(view["name"], data)
    bpy.context.scene.collection.objects.link(camera)
    position = Vector(view["position"])
    target = Vector(view["target"])
    forward = (target - position).normalized()
    right = forward.cross(Vector((0, 1, 0))).normalized()
    matrix = Matrix((right, right.cross(forward), -forward)).transposed().to_4x4()
    matrix.translation = position
    camera.matrix_world = matrix
    return camera


def set_up(job):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.max_bounces = cycles.diffuse_bounces = job["bounces"]
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.pixel_filter_type = "BOX"
    scene.render.filter_size = 1
    cycles.filter_width = 1
    scene.render.resolution_x, scene.render.resolution_y = job["size_px"]
    scene.render.resolution_percentage = 100
    scene.render.threads_mode = "FIXED"
    scene.render.threads = job["threads"]
    scene.render.use_persistent_data = True
    settings = scene.render.image_settings
    settings.file_format = "OPEN_EXR"
    settings.color_depth = "32"
    settings.color_mode = "RGB"
    settings.exr_codec = "NONE"
    return scene


def render(scene, samples, seed):
    scene.cycles.samples = samples
    scene.cycles.seed = seed
    wall = time.perf_counter()
    cpu = time.process_time()
    bpy.ops.render.render()
    return {"wall_s": time.perf_counter() - wall, "cpu_s": time.process_time() - cpu}


def write_picture(path, size_px):
    width, height = size_px
    exr = path.with_suffix(".exr")
    bpy.data.images["Render Result"].save_render(str(exr))
    image = bpy.data.images.load(str(exr))
    image.colorspace_settings.name = "Non-Color"
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    pixels.reshape(height, width, image.channels)[::-1, :, :3].tofile(path)
    bpy.data.images.remove(image)
    exr.unlink()


def main():
    job = json.loads(Path(sys.argv[sys.argv.index("--") + 1]).read_text())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    add_mesh(job["mesh"], job["albedo"])
    add_light(job)
    scene = set_up(job)
    figures = {"blender": bpy.app.version_string, "build_s": 0, "views": {}}
    for view in job["views"]:
        scene.camera = add_camera(view)
        # The same number of samples as later: Cycles keeps that of the first picture for the next
        # one.
        scene.render.resolution_percentage = 5
        first = render(scene, job["samples"], 0)
        scene.render.resolution_percentage = 100
        figures["build_s"] = figures["build_s"] or first["wall_s"]
        of_view = figures["views"][view["name"]] = {}
        for seed in job["seeds"]:
            of_view[str(seed)] = render(scene, job["samples"], seed)
            write_picture(Path(job["pictures"]) / f"{view['name']}-{seed}.f32", job["size_px"])
    Path(job["figures"]).write_text(json.dumps(figures))


main()
