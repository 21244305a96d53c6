#!/usr/bin/env python3
"""The viewer's picture of the demo's square next to the ray tracer's, pixel by pixel.

    equality.py [--size 640x360] [--dates 20] [--keep FOLDER]

Three cameras: share of pixels with the same first voxel, face and level, and how far one sample of
direct light is off. Dates over a year and its days: share of pixels with the same hard shadow. With
--keep, the viewer's pictures and those of `terravox render` are left there as PNG. The last line is
JSON.
"""

import argparse
import json
import pathlib

from viewing import demo_site, render, site_views, temporary_folder


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--dates", type=int, default=20)
    parser.add_argument("--keep", type=pathlib.Path)
    arguments = parser.parse_args()
    size = tuple(map(int, arguments.size.split("x")))
    site = demo_site()
    archive = site / "place.tvx"
    folder = temporary_folder()
    cameras = site_views.three_views(archive)
    minutes = site_views.minutes_of_the_year(arguments.dates)
    dates = [cameras[i % len(cameras)].at(f"date-{i}", minute) for i, minute in enumerate(minutes)]
    names = [camera.name for camera in cameras]
    site_views.show(site, [*cameras, *dates], size, folder, light=names)
    figures = {"cameras": {}, "dates": []}
    for camera in cameras:
        traced = site_views.Traced(archive, camera.flags(size), folder)
        hits = site_views.numbers_of(folder / f"{camera.name}.hits", "i")
        _, same, lit = site_views.compare_hits(hits, traced)
        light = site_views.numbers_of(folder / f"{camera.name}.light", "f")
        figures["cameras"][camera.name] = {
            "same": same,
            "lit": lit,
            "rmse": site_views.rmse_of_light(light, traced),
            "levels": len({bits >> 4 & 31 for bits in hits[3::4] if bits >> 13 & 1}),
        }
    for view in dates:
        traced = site_views.Traced(archive, view.flags(size), folder)
        hits = site_views.numbers_of(folder / f"{view.name}.hits", "i")
        figures["dates"].append(site_views.compare_shadows(hits, traced)[1])
    if arguments.keep is not None:
        arguments.keep.mkdir(parents=True, exist_ok=True)
        for camera in cameras:
            picture = folder / f"{camera.name}.png"
            (arguments.keep / f"{camera.name}-viewer.png").write_bytes(picture.read_bytes())
            out = arguments.keep / f"{camera.name}-tracer.png"
            run = render(archive, *camera.flags(size), "--samples", "8", "-o", out)
            assert run.code == 0, run
    print(json.dumps(figures))


if __name__ == "__main__":
    main()
