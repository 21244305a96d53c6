import assert from 'node:assert/strict';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { test } from 'node:test';
import {
  boundsToDegrees,
  overlap,
  ringOfBox,
  withShortEdges,
} from '../../../grabber/src/geo/bounds.js';
import {
  circlePolygonDeg,
  circleTouchesSquare,
  PolygonIndex,
  touchesSquare,
  type Polygon,
} from '../../../grabber/src/geo/polygon.js';
import { findProjection, type Point } from '../../../grabber/src/geo/crs.js';
import type { BoundsM } from '../../../grabber/src/model/store.js';
import { readPackageInfo } from '../../../grabber/src/util/package-info.js';
import { seededRandom as seeded } from '../portal/pattern.js';

type Geometry = { readonly type: 'Polygon'; readonly coordinates: readonly (readonly Point[])[] };

// Tests lie outside of the package, so its packages are found from its folder.
const { booleanIntersects } = createRequire(join(readPackageInfo().root, 'package.json'))(
  '@turf/boolean-intersects',
) as {
  booleanIntersects: (a: Geometry, b: Geometry) => boolean;
};

test('places are where the national surveys have them', async (t) => {
  // Values of PROJ (gdaltransform). The Bessel datum of D48 has better parameters there than in the
  // index.
  const cases: [crs: string, lonLat: Point, eastNorth: Point, within_m: number][] = [
    ['EPSG:3794', [14.5, 46.05], [461307.139, 101254.902], 0.1],
    ['EPSG:28992', [4.36, 52.01], [84477.282, 447346.846], 0.1],
    ['EPSG:3912', [14.5, 46.05], [461678.098, 100768.596], 8],
    ['EPSG:2154', [3.877, 43.611], [770819.487, 6279498.63], 0.1],
    ['EPSG:2056', [7.4386, 46.9511], [2599997.533, 1200001.916], 0.1],
    ['EPSG:3857', [-123.07, 44.06], [-13700089.732, 5474732.021], 0.1],
    ['EPSG:25832', [9, 51], [500000, 5649824.888], 0.1],
  ];
  for (const [crs, lonLat, eastNorth, within_m] of cases) {
    await t.test(crs, () => {
      const projection = findProjection(crs);
      const [east, north] = projection.fromDegrees(lonLat);
      const off_m = Math.hypot(east - eastNorth[0], north - eastNorth[1]);
      assert.ok(off_m < within_m, `${east},${north}`);
      const [lon, lat] = projection.toDegrees([east, north]);
      assert.ok(Math.hypot(lon - lonLat[0], lat - lonLat[1]) < 1e-6, `${lon},${lat}`);
    });
  }
});

test('a CRS that cannot be used is an error that names it', () => {
  for (const code of ['EPSG:999999', 'EPSG:4326', 'D96/TM', 'EPSG:../../x']) {
    assert.throws(
      () => findProjection(code),
      { code: 'CRS', message: /allowed: EPSG:<number> of a projected CRS/ },
      code,
    );
  }
  assert.throws(() => findProjection('EPSG:3857').fromDegrees([0, NaN]), { code: 'CRS' });
});

test('the box in degrees encloses the box in metres', () => {
  const random = seeded(7);
  const corners: Record<string, Point> = {
    'EPSG:3794': [400e3, 50e3],
    'EPSG:2056': [2500e3, 1100e3],
    'EPSG:28992': [20e3, 350e3],
    'EPSG:2154': [200e3, 6200e3],
  };
  for (const [crs, [e0, n0]] of Object.entries(corners)) {
    const projection = findProjection(crs);
    for (let run = 0; run < 50; ++run) {
      const [west, south] = [e0 + random() * 1e5, n0 + random() * 1e5];
      const box: BoundsM = [west, south, west + 10 + random() * 1e5, south + 10 + random() * 1e5];
      const degrees = boundsToDegrees(box, projection);
      for (let point = 0; point < 20; ++point) {
        const inside: Point = [
          box[0] + random() * (box[2] - box[0]),
          box[1] + random() * (box[3] - box[1]),
        ];
        const [lon, lat] = projection.toDegrees(inside);
        assert.ok(
          lon > degrees[0] && lon < degrees[2] && lat > degrees[1] && lat < degrees[3],
          `${crs} ${box.join()} ${inside.join()}`,
        );
      }
    }
  }
});

test('a polygon touches the squares it has ground in, and not those it only meets', async (t) => {
  const square: BoundsM = [1000, 1000, 2000, 2000];
  const box = (west: number, south: number, east: number, north: number): Polygon => [
    ringOfBox([west, south, east, north]),
  ];
  const around = ringOfBox([0, 0, 9000, 9000]);
  const corner = (cut: number): Polygon => [
    [
      [900, cut],
      [cut, 900],
      [800, 800],
      [900, cut],
    ],
  ];
  const cases: [name: string, polygon: Polygon, touches: boolean][] = [
    ['inside the square', box(1400, 1400, 1500, 1500), true],
    ['around the square', [around], true],
    ['the square itself', box(1000, 1000, 2000, 2000), true],
    ['a common edge', box(2000, 1000, 3000, 2000), false],
    ['a part of an edge', box(0, 1200, 1000, 1300), false],
    ['a common corner', box(2000, 2000, 3000, 3000), false],
    ['a millimetre over the edge', box(1999.999, 1000, 3000, 2000), true],
    ['a corner cut off', corner(1050), false],
    ['a corner cut', corner(1200), true],
    ['through, corners outside', box(0, 1490, 9000, 1510), true],
    ['in a hole', [around, ...box(500, 500, 2500, 2500)], false],
    ['in a hole of its size', [around, ...box(1000, 1000, 2000, 2000)], false],
    ['partly in a hole', [around, ...box(500, 500, 1999, 2500)], true],
  ];
  for (const [name, polygon, touches] of cases) {
    await t.test(name, () => assert.equal(touchesSquare(polygon, square), touches));
  }
});

/** A star around a point: never crosses itself, mostly not convex. */
function star(random: () => number, centre: Point, radius: number, corners: number): Point[] {
  const ring: Point[] = [];
  for (let corner = 0; corner < corners; ++corner) {
    const angle = (2 * Math.PI * corner) / corners;
    const reach = radius * (0.2 + 0.8 * random());
    ring.push([centre[0] + reach * Math.cos(angle), centre[1] + reach * Math.sin(angle)]);
  }
  return [...ring, ring[0] ?? centre];
}

test('which squares a polygon touches agrees with another library and with sampling', () => {
  const random = seeded(42);
  let touched = 0;
  for (let run = 0; run < 60; ++run) {
    const centre: Point = [random() * 4000, random() * 4000];
    const hole = run % 3 === 0 ? [star(random, centre, 150, 5)] : [];
    const polygon: Polygon = [
      star(random, centre, 300 + random() * 1500, 3 + Math.floor(random() * 12)),
      ...hole,
    ];
    for (let east = -1000; east < 5000; east += 1000) {
      for (let north = -1000; north < 5000; north += 1000) {
        const square: BoundsM = [east, north, east + 1000, north + 1000];
        const ours = touchesSquare(polygon, square);
        const theirs = booleanIntersects(geometry(polygon), geometry([ringOfBox(square)]));
        const shown = `run ${run}, square ${square.join()}, polygon ${JSON.stringify(polygon)}`;
        assert.equal(ours, theirs, shown);
        if (ours) ++touched;
        const samples = Array.from({ length: 5 }, (): Point => [
          east + random() * 1000,
          north + random() * 1000,
        ]);
        const ground = new PolygonIndex(polygon);
        if (samples.some((point) => ground.contains(point))) assert.ok(ours, shown);
      }
    }
  }
  assert.ok(touched > 200);
});

function geometry(coordinates: Polygon): Geometry {
  return { type: 'Polygon', coordinates };
}

test('a circle touches the squares nearer than its radius', () => {
  const random = seeded(3);
  for (let run = 0; run < 500; ++run) {
    const [x, y, radius] = [random() * 5000, random() * 5000, random() * 2000];
    const square: BoundsM = [2000, 2000, 3000, 3000];
    const ring = withShortEdges(ringOfBox(square), 1);
    const inside = overlap(square, [x, y, x + 1e-9, y + 1e-9]);
    const nearest = Math.min(...ring.map(([px, py]) => Math.hypot(px - x, py - y)));
    if (Math.abs(nearest - radius) < 1) continue;
    assert.equal(
      circleTouchesSquare([x, y], radius, square),
      inside || nearest < radius,
      `${x},${y},${radius}`,
    );
  }
  assert.ok(
    !circleTouchesSquare([1000, 2500], 1000, [2000, 2000, 3000, 3000]),
    'a circle that only meets the edge',
  );
});

test('a circle in degrees is a circle on the ground', () => {
  for (const [crs, lon, lat] of [
    ['EPSG:3794', 14.5, 46],
    ['EPSG:28992', 5, 52],
    ['EPSG:2056', 8, 47],
  ] as const) {
    const projection = findProjection(crs);
    const [east, north] = projection.fromDegrees([lon, lat]);
    for (const point of circlePolygonDeg([lon, lat], 5000)[0] ?? []) {
      const [x, y] = projection.fromDegrees(point);
      const reach = Math.hypot(x - east, y - north);
      assert.ok(reach > 4998 && reach < 5010, `${crs} ${reach}`);
    }
  }
});
