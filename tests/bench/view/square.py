#!/usr/bin/env python3
"""What a browser takes to show the demo's square kilometre.

    square.py [--seconds 4] [--sizes 320x180,640x360]

Requests, bytes and seconds of the first whole picture at the last size, passes at each size. The
last line is JSON.
"""

import argparse
import json

from viewing import browse, demo_site, script_bytes


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", type=float, default=4)
    parser.add_argument("--sizes", default="320x180,640x360")
    parser.add_argument("--settle-s", type=float, default=60)
    arguments = parser.parse_args()
    site = demo_site()
    figures = {"script_bytes": script_bytes(site), "sizes": {}}
    for size in arguments.sizes.split(","):
        width, height = map(int, size.split("x"))
        found = browse(site, width, height, passes_s=arguments.seconds, settle_s=arguments.settle_s)
        figures["first"] = found.pop("first")
        figures["sizes"][size] = found
    print(json.dumps(figures))


if __name__ == "__main__":
    main()
