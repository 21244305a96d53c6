#!/usr/bin/env python3
"""A flight over 100 km2 in a browser, and the first picture in the middle of it.

    flight.py [--seconds 60] [--size 320x180] [--samples FILE]

The world is noise; the archive of 0.5 GB is made once and kept in TERRAVOX_BENCH_CACHE, where that
is set. The first picture is compared with the same view of 1 km2. Memory is sampled after garbage
has been collected; its slopes are those of lines of least squares, after the first fifth. The last
line is JSON.
"""

import argparse
import json
import pathlib

from viewing import browse, noise_site, slope

SPEED = 100  # metres a second
REACH = 4200  # metres from the middle
HEIGHT = 260
CENTRE = (512, 512)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--size", default="320x180")
    parser.add_argument("--settle-s", type=float, default=60)
    parser.add_argument("--samples", type=pathlib.Path)
    arguments = parser.parse_args()
    width, height = map(int, arguments.size.split("x"))
    small = browse(noise_site(1), 640, 360)
    site = noise_site(100)
    large = browse(site, 640, 360)
    path = {"centre": CENTRE, "reach": REACH, "height": HEIGHT, "speed": SPEED}
    every_s = max(1, arguments.seconds / 60)
    flown = browse(
        site,
        width,
        height,
        settle_s=arguments.settle_s,
        flight={"seconds": arguments.seconds, "every_s": every_s, **path},
    )
    samples = flown.pop("flight")
    if arguments.samples is not None:
        arguments.samples.write_text(json.dumps(samples))
    late = samples[len(samples) // 5 :]
    live = [sum(sample["live"].values()) for sample in late]
    figures = {
        "small": small["first"],
        "large": large["first"],
        "pool_bytes": flown["pool_bytes"],
        "texture_bytes": max(sample["texture_bytes"] for sample in samples),
        "frames": samples[-1]["frames"],
        "requests": samples[-1]["requests"],
        "bytes": samples[-1]["bytes"],
        "fill": max(sample["fill"] for sample in samples),
        "objects_more": max(live) - min(live),
        "textures_made": samples[-1]["made"]["Texture"],
        "textures_live": samples[-1]["live"]["Texture"],
    }
    for who in ("page", "worker"):
        key = f"{who}_bytes"
        figures[f"{who}_used_slope"] = slope(late, f"{who}_used_bytes")
        figures[f"{who}_slope"] = slope(late, key)
        figures[f"{who}_peak"] = max(sample[key] for sample in samples)
        figures[f"{who}_used_peak"] = max(sample[f"{who}_used_bytes"] for sample in samples)
    print(json.dumps(figures))


if __name__ == "__main__":
    main()
