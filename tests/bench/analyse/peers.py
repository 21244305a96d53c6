"""What the scripts of the entries analyse/... have in common: heights as files, programs, peers.

A script gets the folder for its files, and writes its readings, [metric, unit, value, bound], to
figures.json there. A bound is "<= 0.5", ">= 0.99" or "". Needs NumPy and GDAL's programs."""

import argparse
import importlib
import json
import pathlib
import re
import resource
import shutil
import subprocess

import numpy

NO_DATA = -9999
CRS = "EPSG:3794"
# On the middle meridian of the CRS, where north of the map is north.
WEST, NORTH = 500000, 101000


class Bench:
    """The program that is measured, a folder, and what has been read."""

    def __init__(self, description):
        parser = argparse.ArgumentParser(description=description)
        parser.add_argument("scratch", type=pathlib.Path)
        parser.add_argument("--program", default="terravox-raytracer")
        parser.add_argument("--survey", default="", help="folder of a synthetic survey")
        parser.add_argument("--cases", default="", help="values of Terravox to be compared")
        args = parser.parse_args()
        self.scratch = args.scratch
        self.program = args.program
        self.survey = pathlib.Path(args.survey)
        self.cases = args.cases
        self.readings = []
        self.notes = []

    def add(self, metric, unit, value, bound=""):
        self.readings.append([metric, unit, float(value), bound])

    def note(self, text):
        self.notes.append(text)

    def finish(self):
        figures = {"readings": self.readings, "notes": self.notes}
        (self.scratch / "figures.json").write_text(json.dumps(figures), encoding="utf-8")

    def analyse(self, kind, *words):
        """Runs an analysis.

        @return its bands by name, and CPU seconds
        """
        out = self.scratch / f"{kind}.tif"
        seconds = run(self.program, "analyse", kind, *words, "-q", "-o", out)
        return bands_of(out, self.scratch), seconds


def run(*words):
    """@return CPU seconds"""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([str(word) for word in words], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def grass(scratch, *commands):
    """Runs commands of GRASS in a map of its own. @return CPU seconds"""
    script = scratch / "grass.sh"
    script.write_text("set -e\n" + "\n".join(commands) + "\n", encoding="utf-8")
    return run("grass", "--tmp-location", CRS, "--exec", "sh", script)


def own_seconds(work):
    """@return what work() gives, and the CPU seconds of this process"""
    before = resource.getrusage(resource.RUSAGE_SELF)
    out = work()
    after = resource.getrusage(resource.RUSAGE_SELF)
    return out, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def module(name):
    """@return a Python module, or None where it is not installed"""
    try:
        return importlib.import_module(name)
    except ImportError:
        return None


def installed(program):
    return shutil.which(program) is not None


def bands_of(file, scratch):
    """@return bands by name; one without a name by its number"""
    text = subprocess.run(
        ["gdalinfo", "-json", str(file)], check=True, capture_output=True, text=True
    ).stdout
    names = [band.get("description", str(band["band"])) for band in json.loads(text)["bands"]]
    raw = scratch / "bands.raw"
    options = ["-q", "-of", "ENVI", "-co", "INTERLEAVE=BSQ", "-ot", "Float32"]
    run("gdal_translate", *options, file, raw)
    header = raw.with_suffix(".hdr").read_text(encoding="utf-8")
    rows = int(re.search(r"lines\s*=\s*(\d+)", header).group(1))
    values = numpy.fromfile(raw, "<f4").reshape(len(names), rows, -1)
    return dict(zip(names, values, strict=True))


def latitude_longitude(east, north):
    words = ["gdaltransform", "-s_srs", CRS, "-t_srs", "EPSG:4326", "-output_xy"]
    found = subprocess.run(
        words, input=f"{east} {north}\n", check=True, capture_output=True, text=True
    ).stdout.split()
    return float(found[1]), float(found[0])


def sun_of(date, hour_utc, lat, lon):
    """@return altitude with refraction and azimuth of the sun, degrees, by pvlib"""
    pandas = module("pandas")
    pvlib = module("pvlib")
    times = pandas.DatetimeIndex([pandas.Timestamp(date, tz="UTC")])
    times += pandas.Timedelta(minutes=round(hour_utc * 60))
    sun = pvlib.solarposition.get_solarposition(times, lat, lon)
    return float(sun["apparent_elevation"].iloc[0]), float(sun["azimuth"].iloc[0])


def direction_of(altitude_deg, azimuth_deg):
    """@return east, north, up; of unit length"""
    altitude = numpy.radians(altitude_deg)
    azimuth = numpy.radians(azimuth_deg)
    level = numpy.cos(altitude)
    return numpy.stack(
        [level * numpy.sin(azimuth), level * numpy.cos(azimuth), numpy.sin(altitude)]
    )


def write_heights(file, heights):
    """Writes a raster of heights in cells of 1 m, the north row first."""
    rows, columns = heights.shape
    raw = file.with_suffix(".raw")
    heights.astype("<f4").tofile(raw)
    raw.with_suffix(".hdr").write_text(
        f"ENVI\nsamples = {columns}\nlines = {rows}\nbands = 1\nheader offset = 0\n"
        "file type = ENVI Standard\ndata type = 4\ninterleave = bsq\nbyte order = 0\n",
        encoding="utf-8",
    )
    corners = [WEST, NORTH, WEST + columns, NORTH - rows]
    run("gdal_translate", "-q", "-a_srs", CRS, "-a_ullr", *corners, raw, file)


def town(side, seed=7):
    """@return heights of an invented town, whole metres"""
    random = numpy.random.default_rng(seed)
    y, x = numpy.mgrid[0:side, 0:side]
    heights = numpy.round(300 + 6 * numpy.sin(x / 90) + 6 * numpy.cos(y / 70))
    for _ in range(side * side // 2500):
        row, column = random.integers(5, side - 30, 2)
        deep, wide = random.integers(8, 25, 2)
        part = heights[row : row + deep, column : column + wide]
        part[:] = numpy.round(part.mean()) + random.integers(4, 25)
    return heights


def near_edge(mask, reach=1):
    """@return the cells with another answer within `reach` cells"""
    out = numpy.zeros(mask.shape, bool)
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            out |= numpy.roll(numpy.roll(mask, dy, 0), dx, 1) != mask
    return out
