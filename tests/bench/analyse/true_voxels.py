"""The truth of a synthetic survey as voxels: what a survey without errors and gaps would give.

Needs the Python package terravox (PYTHONPATH=build/release/python) and xarray."""

import numpy

from survey_truth import EDGE_M


def cut(values, shape, times):
    """@return the rows and columns that fill whole voxels"""
    return values[: shape[0] * times, : shape[1] * times]


def mean_of(values, shape, times):
    """@return means over the columns of each voxel"""
    return values.reshape(shape[0], times, shape[1], times).mean((1, 3))


def layer_of(columns, shape, bottom, voxel_m, numbers):
    """@return the materials of one layer of voxels: each is solid where half of it is, of what most
    of it is"""
    times = round(voxel_m / EDGE_M)
    ground = (cut(columns.ground, shape, times) - bottom).clip(0, voxel_m)
    solid = ground.copy()
    parts = [mean_of(ground, shape, times)]
    names = ["ground"]
    for name, (low, high) in columns.layers.items():
        low, high = cut(low, shape, times), cut(high, shape, times)
        share = (numpy.minimum(high, bottom + voxel_m) - numpy.maximum(low, bottom)).clip(0, None)
        parts.append(mean_of(share, shape, times))
        names.append(name)
        solid = numpy.maximum(solid, share)
    words = {"building": "roof", "slab": "roof", "deck": "bridge", "crown": "high_vegetation"}
    materials = numpy.array([numbers[words.get(name, name)] for name in names], numpy.uint8)
    found = materials[numpy.argmax(parts, 0)]
    return numpy.where(mean_of(solid, shape, times) >= voxel_m / 2, found, 0)


def write_true_voxels(columns, voxel_m, crs, archive):
    """Writes the truth as a box archive. @raise ImportError without the Python package"""
    import terravox

    numbers = {material.name: material.number for material in terravox.MATERIALS}
    times = round(voxel_m / EDGE_M)
    shape = (columns.shape[0] // times, columns.shape[1] // times)
    bottom = numpy.floor(columns.ground.min()) - 2
    count = int(numpy.ceil((columns.highest - bottom) / voxel_m)) + 1
    layers = [
        layer_of(columns, shape, bottom + i * voxel_m, voxel_m, numbers) for i in range(count)
    ]
    # What has a roof above it is a wall.
    for lower, upper in zip(layers[-2::-1], layers[:0:-1], strict=True):
        covered = numpy.isin(upper, [numbers["roof"], numbers["wall"]])
        lower[(lower == numbers["roof"]) & covered] = numbers["wall"]
    with terravox.from_voxels(
        numpy.stack(layers),
        west=columns.west,
        south=columns.north - shape[0] * voxel_m,
        bottom=bottom,
        voxel_m=voxel_m,
        crs=crs,
    ) as world:
        world.convert(archive)
