"""Point clouds."""

from checks import SLOVENIA, Row, Strangers, las
from las_files import GEOCENTRIC, SITE_GRID, Record, copc_records, key_record, wkt_record

OTHER_KEYS = key_record((1024, 1), (1025, 1), (3072, 32632))
UNITS_ALONE = key_record((1024, 1), (1025, 2), (3076, 9001), (4099, 9001))


def system_of(name, says="", **facts):
    return Row(name, "las", las(**facts), says=says)


LAS_ROWS = [
    system_of("a WKT record", records=(wkt_record(),)),
    system_of("a WKT record behind the points", records=(), extended=(wkt_record(),)),
    system_of("keys behind the points", records=(), extended=(key_record(),)),
    system_of("WKT behind the points, other keys", records=(OTHER_KEYS,), extended=(wkt_record(),)),
    system_of("no WKT in the WKT record", records=(wkt_record("not specified"), key_record())),
    system_of(
        "no WKT in the first record",
        records=(wkt_record("not specified"),),
        extended=(wkt_record(),),
    ),
    system_of(
        "a superseded record",
        records=(Record("LASF_Spec", 7, wkt_record(SITE_GRID).payload), key_record()),
    ),
    system_of("records of another user", records=(Record("else", 2112, b"LOCAL"), key_record())),
    system_of("LAS 1.2", minor=2, point_format=1),
    system_of("LAS 1.3", minor=3, point_format=3),
    system_of("LAS 1.5", minor=5, records=(wkt_record(),)),
    system_of("LAS 1.5 in colour", minor=5, point_format=7, records=(wkt_record(),)),
    system_of("LAS 1.5, WKT behind", minor=5, records=(), extended=(wkt_record(),)),
    system_of(
        "records behind the end",
        extended=(wkt_record(SITE_GRID),),
        extended_at=1 << 40,
        says="an extended record runs beyond the end",
    ),
    system_of(
        "a record that is too long",
        extended=(wkt_record(SITE_GRID),),
        extra_record_bytes=1 << 50,
        says="an extended record runs beyond the end",
    ),
    system_of(
        "records of COPC in another order of points",
        point_format=7,
        records=(copc_records(), key_record()),
        says="its index is not used, since it does not fit",
    ),
    Row(
        "LAS 1.5 of an old format", "las", las(minor=5, point_format=1), refused="allowed: 6 to 10"
    ),
    Row("LAS 1.5 without a system", "las", las(minor=5, records=()), refused="--crs EPSG:"),
    Row("a site's own grid", "las", las(records=(wkt_record(SITE_GRID),)), refused="--crs EPSG:"),
    Row(
        "axes from the Earth's centre",
        "las",
        las(records=(wkt_record(GEOCENTRIC),)),
        refused="its axes begin at the Earth's centre",
    ),
    Row(
        "heights in a unit that no key has",
        "las",
        las(records=(key_record((1024, 1), (1025, 1), (3072, 3794), (4099, 9999)),)),
        refused="unit of heights = 9999",
    ),
    Row("a unit alone", "las", las(records=(UNITS_ALONE,)), refused="--crs EPSG:"),
    Row(
        "a site's own grid, placed by the user",
        "las",
        las(records=(wkt_record(SITE_GRID),)),
        flags=("--crs", SLOVENIA),
    ),
    Row(
        "black points first",
        "las",
        las(point_format=7, red=lambda i: 0 if i < 2048 else 200 * 257),
        means={"red": 100},
    ),
    Row(
        "dark points first",
        "las",
        las(point_format=7, red=lambda i: 200 if i < 1024 else 60 * 257),
        means={"red": 45},
    ),
    Row("colours of 8 bits", "las", las(point_format=7, red=lambda _: 200), means={"red": 200}),
    Row("colours of 16 bits", "las", las(point_format=7, red=lambda _: 51400), means={"red": 200}),
]


class Points(Strangers):
    def test_las_files(self):
        self.check_all(LAS_ROWS)
