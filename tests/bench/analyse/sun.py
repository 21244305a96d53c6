#!/usr/bin/env python3
"""Directions of the sun, and light of the sky on tilted planes, beside pvlib (PyPI): NREL's SPA,
and the model of Perez. The values of Terravox come as a file of cases."""

import json
import pathlib

import numpy

from peers import Bench, direction_of, module

# Where refraction, of which the peer has another formula, is below a thousandth of a degree's
# difference.
HIGH_DEG = 15


def directions(bench, spa, cases):
    """@param cases rows of seconds, latitude, longitude, altitude with refraction, azimuth"""
    pandas = module("pandas")
    far = []
    for second, lat, lon, altitude, azimuth in cases:
        if altitude < HIGH_DEG:
            continue
        at = pandas.Timestamp(int(second), unit="s")
        delta_t = float(spa.calculate_deltat(at.year, at.month))
        peer = spa.solar_position(
            numpy.array([float(second)]), lat, lon, 0, 1010, 12, delta_t, 0.5667
        )
        apart = direction_of(altitude, azimuth) - direction_of(peer[2, 0], peer[4, 0])
        far.append(numpy.degrees(2 * numpy.arcsin(numpy.linalg.norm(apart) / 2)))
    bench.add("cases compared", "", len(far))
    bench.add("direction of the sun: greatest difference", "degree", max(far), "<= 0.01")
    bench.add(
        "direction of the sun: root mean square",
        "degree",
        numpy.sqrt(numpy.mean(numpy.square(far))),
    )


def planes(bench, irradiance, cases):
    """@param cases rows of altitude, beam, diffuse, extraterrestrial, air mass, tilt, turn from the
    sun's azimuth, light of the sky on the plane by Perez, beam on it"""
    columns = numpy.array(cases).T
    altitude, beam, diffuse, outside, mass, tilt, turn, sky, direct = columns
    zenith = 90 - altitude
    peer = irradiance.perez(tilt, turn, diffuse, beam, outside, zenith, 0, mass)
    peer_direct = irradiance.beam_component(tilt, turn, zenith, 0, beam)
    lit = peer > 1
    bench.add(
        "diffuse light of tilted planes: greatest difference",
        "%",
        100 * numpy.abs(sky / peer - 1)[lit].max(),
        "<= 0.5",
    )
    bench.add(
        "beam of tilted planes: greatest difference",
        "W/m2",
        numpy.abs(direct - peer_direct).max(),
        "<= 0.001",
    )


def main():
    bench = Bench(__doc__)
    pvlib = module("pvlib")
    spa = module("pvlib.spa")
    cases = json.loads(pathlib.Path(bench.cases).read_text(encoding="utf-8"))
    directions(bench, spa, cases["sun"])
    planes(bench, pvlib.irradiance, cases["planes"])
    bench.note(f"pvlib {pvlib.__version__}.")
    bench.finish()


if __name__ == "__main__":
    main()
