#!/usr/bin/env python3
"""What a browser takes to show the demo's square kilometre.

Requests, bytes and seconds of the first whole picture at the last size, passes at each size. The
last line is JSON.
"""

import json

from viewing import browse, demo_site, script_bytes

PASSES_S = 4
SETTLE_S = 60
SIZES = ((320, 180), (640, 360))


def main():
    site = demo_site()
    figures = {"script_bytes": script_bytes(site), "sizes": {}}
    for width, height in SIZES:
        found = browse(site, width, height, passes_s=PASSES_S, settle_s=SETTLE_S)
        figures["first"] = found.pop("first")
        figures["sizes"][f"{width}x{height}"] = found
    print(json.dumps(figures))


if __name__ == "__main__":
    main()
