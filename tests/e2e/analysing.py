"""Analyses of a part of the synthetic survey, for the tests of them."""

from support import Run, binary, entries, square, temporary_folder

TERRAIN = ["dsm", "dtm", "ndsm", "slope", "aspect", "hillshade", "class", "material"]
TERRAIN += ["red", "green", "blue", "dtm_source", "hole"]
SIGHT = ["seen", "distance_m", "class", "material", "hole"]
PERIOD = ["sun_hours", "sun_hours_per_day", "sun_share", "hole"]
MONTHS = "january february march april may june july august september october november december"
MONTHS = ["sun_hours", *MONTHS.split(), "hole"]
YEAR = ["--from", "2026-01-01", "--to", "2026-12-31", "--step-min", "60", "--bin-deg", "15"]
ENERGY = ["kwh_m2", "beam", "diffuse", "reflected", "slope", "aspect"]
ENERGY += ["sun_hours", "material", "hole"]
CROWNS = ["energy", *YEAR, "--directions", "64", "--surface", "ground", "--crown-light"]
SKY = ["svf", "sky_view_solid", "openness", "hole"]
NO_DATA = -9999

_rasters = {}


def analyse(*arguments, program=(), **options):
    """@param program: what starts the analysis"""
    return Run([*program, binary("RAYTRACER"), "analyse", *arguments], **options)


def area():
    """@return a part of the survey: west, south, east, north"""
    name = square().stem  # TM_EAST_NORTH, in metres or kilometres
    east, north = (int(number) for number in name.split("_")[1:])
    if east < 10000:
        east, north = 1000 * east, 1000 * north
    return east + 60, north + 40, east + 190, north + 150


def area_flag():
    return ["--area", ",".join(str(number) for number in area())]


def village():
    """@return the flag of a part of the survey with many buildings"""
    west, south = area()[0] - 60, area()[1] - 40
    return ["--area", f"{west + 206},{south + 126},{west + 256},{south + 256}"]


def observer(above=20):
    """@return one above the middle of the part"""
    west, south, east, north = area()
    return ["--observer", f"{(west + east) / 2 + 0.25},{(south + north) / 2},+{above}"]


def needed(kind):
    """@return the flags without which there is no such analysis"""
    return observer() if kind == "sight" else []


def raster(kind, *flags):
    """@return the file of an analysis of the part"""
    key = (kind, *flags)
    if key not in _rasters:
        file = temporary_folder() / "a.tif"
        flags = [*needed(kind), *flags]
        run = analyse(kind, square(), *area_flag(), *flags, "--quiet", "-o", file)
        if run.code != 0 or run.out:
            raise AssertionError(str(run))
        if entries(file.parent) != ["a.tif"]:
            raise AssertionError(f"left behind: {entries(file.parent)}")
        _rasters[key] = file
    return _rasters[key]
