"""The truth of a synthetic survey as columns of half a metre: ground, and up to three things above
it that each have an underside; and what rays through these columns meet."""

import json

import numpy

from peers import bands_of

EDGE_M = 0.5
NEAR_M = 60  # up to here rays are walked in steps of half a column, beyond in whole ones
DECK_M = 0.6  # the survey's bridges are sheets
PARAPET_M = 1.1
PARAPET_WIDTH_M = 0.4
NOTHING = 1e9
DIRECTIONS = 128


class Columns:
    """Ground, and layers of things as undersides and tops, by row from the north."""

    def __init__(self, extent):
        self.west, self.south, self.east, self.north = extent
        self.shape = (
            round((self.north - self.south) / EDGE_M),
            round((self.east - self.west) / EDGE_M),
        )
        self.ground = numpy.zeros(self.shape)
        self.highest = 0.0
        self.water = numpy.full(self.shape, -NOTHING)  # below bridges
        self.layers = {
            name: (numpy.full(self.shape, NOTHING), numpy.full(self.shape, -NOTHING))
            for name in ("building", "slab", "deck", "crown")
        }

    def window(self, west, south, east, north):
        """@return slices of the columns in a box, and their middles, or None"""
        row0 = max(int((self.north - north) / EDGE_M), 0)
        row1 = min(int((self.north - south) / EDGE_M) + 1, self.shape[0])
        column0 = max(int((west - self.west) / EDGE_M), 0)
        column1 = min(int((east - self.west) / EDGE_M) + 1, self.shape[1])
        if row0 >= row1 or column0 >= column1:
            return None
        y, x = numpy.mgrid[row0:row1, column0:column1]
        part = (slice(row0, row1), slice(column0, column1))
        return part, self.west + (x + 0.5) * EDGE_M, self.north - (y + 0.5) * EDGE_M

    def add(self, layer, part, inside, bottom, top):
        low, high = self.layers[layer]
        low[part] = numpy.where(inside, numpy.minimum(low[part], bottom), low[part])
        high[part] = numpy.where(inside, numpy.maximum(high[part], top), high[part])

    def tops(self):
        return numpy.maximum(self.ground, numpy.max([high for _, high in self.layers.values()], 0))


def in_polygon(x, y, corners):
    inside = numpy.zeros(x.shape, bool)
    for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1], strict=True):
        if y0 == y1:
            continue
        inside ^= ((y0 > y) != (y1 > y)) & (x < (x1 - x0) * (y - y0) / (y1 - y0) + x0)
    return inside


def add_building(columns, building):
    corners = building["footprint"]
    east, north = numpy.array(corners).T
    found = columns.window(east.min(), north.min(), east.max(), north.max())
    if found is None:
        return
    part, x, y = found
    inside = in_polygon(x, y, corners)
    if "underside_m" in building:
        columns.add("slab", part, inside, building["underside_m"], building["eaves_m"])
    else:
        columns.add("building", part, inside, -NOTHING, roof_top(building, x, y))


def roof_top(building, x, y):
    """@return heights of a building's roof, without battlements"""
    corners = numpy.array(building["footprint"])
    middle_x, middle_y = corners.mean(0)
    rise = building["ridge_m"] - building["eaves_m"]
    # The first side runs along the ridge.
    side = corners[1] - corners[0]
    half_length = numpy.hypot(*side) / 2
    half_width = numpy.hypot(*(corners[2] - corners[1])) / 2
    along_x, along_y = side / (2 * half_length)
    along = numpy.abs((x - middle_x) * along_x + (y - middle_y) * along_y)
    across = numpy.abs((y - middle_y) * along_x - (x - middle_x) * along_y)
    if building["roof"] == "flat":
        share = numpy.zeros(x.shape)
    elif building["roof"] == "gable":
        share = 1 - across / half_width
    elif building["roof"] == "hip":
        share = numpy.minimum(half_width - across, half_length - along) / half_width
    elif building["roof"] == "pyramid":
        share = 1 - numpy.maximum(along / half_length, across / half_width)
    elif building["roof"] == "cone":
        radius = numpy.hypot(corners[0][0] - middle_x, corners[0][1] - middle_y)
        share = 1 - numpy.hypot(x - middle_x, y - middle_y) / radius
    else:
        raise ValueError(f"a roof of kind {building['roof']}")
    return building["eaves_m"] + rise * share.clip(0, 1)


def add_bridge(columns, bridge):
    (x0, y0), (x1, y1) = bridge["line"]
    half = bridge["width_m"] / 2
    found = columns.window(
        min(x0, x1) - half, min(y0, y1) - half, max(x0, x1) + half, max(y0, y1) + half
    )
    if found is None:
        return
    part, x, y = found
    length = numpy.hypot(x1 - x0, y1 - y0)
    along = ((x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)) / length
    across = numpy.abs((x - x0) * (y1 - y0) - (y - y0) * (x1 - x0)) / length
    inside = (along >= 0) & (along <= length) & (across <= half)
    top = bridge["deck_m"] + PARAPET_M * (across > half - PARAPET_WIDTH_M)
    columns.add("deck", part, inside, bridge["deck_m"] - DECK_M, top)
    columns.water[part] = numpy.where(inside, bridge["water_m"], columns.water[part])


def add_tree(columns, tree):
    radius = tree["crown_radius_m"]
    east, north = tree["at"]
    found = columns.window(east - radius, north - radius, east + radius, north + radius)
    if found is None:
        return
    part, x, y = found
    share = numpy.hypot(x - east, y - north) / radius
    inside = share <= 1
    share = numpy.minimum(share, 1)
    slender = radius / tree["height_m"]
    base = {
        "conifer": 0.2 if tree["height_m"] > 18.5 else 0.08,
        "broadleaf": 0.38 if slender < 0.235 else 0.24,
    }.get(tree["kind"], 0.15 / tree["height_m"])
    base *= tree["height_m"]
    if tree["kind"] == "conifer":
        top = tree["height_m"] + (base - tree["height_m"]) * share
        bottom = numpy.full(share.shape, base)
    else:
        middle = (tree["height_m"] + base) / 2
        bulge = (tree["height_m"] - middle) * numpy.sqrt(1 - share * share)
        top, bottom = middle + bulge, middle - bulge
    columns.add("crown", part, inside, tree["ground_m"] + bottom, tree["ground_m"] + top)


def true_columns(folder, scratch):
    name = json.loads((folder / "truth/place.json").read_text(encoding="utf-8"))["files"][0]["name"]
    truth = json.loads((folder / f"truth/truth_{name}.json").read_text(encoding="utf-8"))
    columns = Columns(truth["extent_m"])
    ground = next(iter(bands_of(folder / f"truth/ground_{name}.tif", scratch).values()))
    times = round(1 / EDGE_M)
    columns.ground = ground.repeat(times, 0).repeat(times, 1).astype(float)
    for building in truth["buildings"]:
        add_building(columns, building)
    for bridge in truth["bridges"]:
        add_bridge(columns, bridge)
    for tree in truth["trees"]:
        add_tree(columns, tree)
    columns.highest = columns.tops().max()
    return columns


def is_free(columns, eyes, direction, only_tops):
    """Whether rays are free, as far as the survey reaches.

    @param eyes rows of east, north, height
    @param direction east, north, up
    """
    east, north, up = direction
    level = max(numpy.hypot(east, north), 1e-9)
    free = numpy.ones(len(eyes), bool)
    going = numpy.arange(len(eyes))
    distance = 0.01
    while len(going) > 0:
        step = EDGE_M / 2 if distance < NEAR_M else EDGE_M
        t = distance / level
        x, y, z = eyes[going, 0] + east * t, eyes[going, 1] + north * t, eyes[going, 2] + up * t
        column = numpy.floor((x - columns.west) / EDGE_M).astype(int)
        row = numpy.floor((columns.north - y) / EDGE_M).astype(int)
        inside = (row >= 0) & (column >= 0) & (row < columns.shape[0]) & (column < columns.shape[1])
        inside &= z <= columns.highest
        going, row, column, z = going[inside], row[inside], column[inside], z[inside]
        if only_tops is not None:
            met = z < only_tops[row, column]
        else:
            # A whole step, so that steep rays miss no thin slab.
            z1 = z + up / level * step
            met = z < columns.ground[row, column]
            for low, high in columns.layers.values():
                met |= (z1 > low[row, column]) & (z < high[row, column])
        free[going[met]] = False
        going = going[~met]
        distance += step
    return free


def directions():
    """@return directions by the cosine of the zenith angle: each has the same share of the sky-view
    factor"""
    i = numpy.arange(DIRECTIONS)
    sine2 = (i + 0.5) / DIRECTIONS
    azimuth = i * 2.39996322972865332
    level = numpy.sqrt(sine2)
    return numpy.stack(
        [level * numpy.sin(azimuth), level * numpy.cos(azimuth), numpy.sqrt(1 - sine2)], 1
    )


def sky_view(columns, eyes, only_tops):
    return numpy.mean([is_free(columns, eyes, to, only_tops) for to in directions()], 0)
