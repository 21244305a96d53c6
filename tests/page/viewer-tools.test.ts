import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Vec3 } from '../../voxelserver/serve/page/src/vec3.js';
import type { Pick } from '../../voxelserver/serve/page/src/viewer/stage.js';
import { measurePath } from '../../voxelserver/serve/page/src/viewer/ui/measures.js';
import { toCamera, type Viewpoint } from '../../voxelserver/serve/page/src/viewer/ui/navigation.js';
import { keyTarget } from '../../voxelserver/serve/page/src/viewer/ui/profile-chart.js';
import {
  toCsv,
  toFacts,
  finest,
  placesAlong,
  raysDown,
  makeSamples,
  chooseTicks,
} from '../../voxelserver/serve/page/src/viewer/ui/profile-line.js';
import {
  clipped,
  projectSegment,
  projectPoint,
  spotOfDirection,
} from '../../voxelserver/serve/page/src/viewer/ui/projection.js';
import {
  readSection,
  toSection,
  sectionWord,
  through,
  type SectionPlane,
} from '../../voxelserver/serve/page/src/viewer/ui/section-plane.js';
import { toSight, sightRay } from '../../voxelserver/serve/page/src/viewer/ui/sight-line.js';
import { isNear } from './support/near.js';
import { makeShare } from './support/test-bytes.js';

function pickAt(point: Vec3, distance: number, level = 0): Pick {
  return {
    voxel: [0, 0, 0],
    level,
    face: 3,
    distance,
    point,
    material: 1,
    colour: undefined,
    isInSun: true,
    lidarClass: undefined,
    isVisible: undefined,
  };
}

// --- Measuring

test('a line of points has lengths, heights, slope and azimuth', () => {
  const m = measurePath(
    [
      [0, 0, 0],
      [30, 0, -40],
      [30, 60, -40],
    ],
    0.5,
  );
  isNear(m.slopeM, 25 + 30);
  isNear(m.horizontalM, 25);
  isNear(m.heightM, 30);
  isNear(m.spanM, 25);
  isNear(m.azimuthDeg!, (Math.atan2(30, 40) * 180) / Math.PI);
  const empty = measurePath([], 1);
  assert.equal(empty.slopeM, 0);
  assert.equal(empty.azimuthDeg, undefined);
});

test('azimuths go clockwise from north', () => {
  for (const [to, azimuth] of [
    [[0, 0, -5], 0],
    [[5, 0, 0], 90],
    [[0, 0, 5], 180],
    [[-5, 0, 0], 270],
  ] as const) {
    isNear(measurePath([[0, 0, 0], to], 1).azimuthDeg!, azimuth);
  }
  assert.equal(
    measurePath(
      [
        [0, 0, 0],
        [0, 9, 0],
      ],
      1,
    ).azimuthDeg,
    undefined,
  );
});

test('areas do not depend on where in a country they lie, on slope or on direction', () => {
  const square = (x: number, z: number): Vec3[] => [
    [x, 3, z],
    [x + 20, 90, z],
    [x + 20, 7, z + 10],
    [x, 1, z + 10],
  ];
  for (const points of [square(0, 0), square(5e8, -5e8), square(7, 9).reverse()]) {
    const m = measurePath(points, 0.5);
    isNear(m.areaM2, 50);
    isNear(m.perimeterM, 30);
  }
});

// --- Projection

const kView: Viewpoint = { position: [10, 20, -30], headingDeg: 40, pitchDeg: -10, fovDeg: 42 };
const kSize = [640, 360] as const;

test('a point is projected onto the pixel whose ray meets it', () => {
  const random = makeShare(3);
  const camera = toCamera(kView);
  for (let i = 0; i < 200; ++i) {
    const [x, y] = [random() * kSize[0], random() * kSize[1]];
    // As the ray of the pixel in trace.glsl.
    const across = (2 * x - kSize[0]) / kSize[1];
    const upward = (kSize[1] - 2 * y) / kSize[1];
    const away = 1 + random() * 1000;
    const point = [0, 1, 2].map(
      (a) =>
        camera.position[a]! +
        away * (camera.forward[a]! + across * camera.right[a]! + upward * camera.up[a]!),
    ) as unknown as Vec3;
    const spot = projectPoint(camera, kSize, point)!;
    isNear(spot[0], x, 1e-6);
    isNear(spot[1], y, 1e-6);
    const direction = [0, 1, 2].map((a) => point[a]! - camera.position[a]!) as unknown as Vec3;
    isNear(spotOfDirection(camera, kSize, direction)![0], x, 1e-6);
  }
});

test('what lies behind the camera has no place in the picture', () => {
  const camera = toCamera({ ...kView, position: [0, 0, 0], headingDeg: 0, pitchDeg: 0 });
  assert.equal(projectPoint(camera, kSize, [0, 0, 5]), undefined);
  assert.equal(projectPoint(camera, kSize, [0, 0, 0]), undefined);
  assert.equal(spotOfDirection(camera, kSize, [0, 0, 1]), undefined);
  assert.equal(spotOfDirection(camera, kSize, [1, 0, 0]), undefined);
  assert.equal(projectSegment(camera, kSize, [0, 0, 5], [3, 2, 9]), undefined);
  assert.deepEqual(projectPoint(camera, kSize, [0, 0, -5]), [320, 180]);
});

test('a segment that passes the camera is cut in front of it, and at the edges', () => {
  const camera = toCamera({ ...kView, position: [0, 0, 0], headingDeg: 0, pitchDeg: 0 });
  const ahead: Vec3 = [0, 0, -100];
  const [from, to] = projectSegment(camera, kSize, [4, 1, 60], ahead)!;
  for (const [x, y] of [from, to]) {
    assert.ok(x >= -1e-6 && x <= 640 + 1e-6 && y >= -1e-6 && y <= 360 + 1e-6, `${x}, ${y}`);
  }
  isNear(to[0], 320);
  isNear(to[1], 180);
  // The other way round it is the same line.
  const [back, start] = projectSegment(camera, kSize, ahead, [4, 1, 60])!;
  isNear(start[0], from[0]);
  isNear(back[1], to[1]);
});

test('segments are clipped to the picture', () => {
  assert.deepEqual(clipped([-10, 50], [110, 50], [100, 100]), [
    [0, 50],
    [100, 50],
  ]);
  assert.deepEqual(clipped([10, 10], [20, 30], [100, 100]), [
    [10, 10],
    [20, 30],
  ]);
  assert.equal(clipped([-10, 5], [-1, 50], [100, 100]), undefined);
  assert.equal(clipped([-10, 105], [110, 101], [100, 100]), undefined);
  assert.equal(clipped([-50, 40], [40, -50], [100, 100]), undefined);
  assert.equal(clipped([50, -5], [50, -5], [100, 100]), undefined);
});

// --- Profile

const kWorld = { min: [0, 0, 0], max: [100, 50, 100], voxelM: 0.5 } as const;

test('a profile goes along all segments, evenly, at most 512 times', () => {
  const line: readonly Vec3[] = [
    [0, 5, 0],
    [30, 9, 0],
    [30, 1, 40],
  ];
  const places = placesAlong(line);
  assert.equal(places.length, 71);
  assert.deepEqual(places[0], { x: 0, z: 0, t: 0 });
  assert.deepEqual(places.at(-1), { x: 30, z: 40, t: 70 });
  isNear(places[30]!.x, 30);
  isNear(places[50]!.z, 20);
  assert.equal(
    placesAlong([
      [0, 0, 0],
      [9999, 0, 0],
    ]).length,
    512,
  );
  assert.deepEqual(placesAlong([[0, 0, 0]]), []);
  assert.deepEqual(
    placesAlong([
      [1, 0, 1],
      [1, 9, 1],
    ]),
    [],
    'points above each other',
  );
  const twice: readonly Vec3[] = [
    [0, 0, 0],
    [0, 0, 0],
    [4, 0, 0],
    [4, 0, 0],
  ];
  assert.deepEqual(
    placesAlong(twice).map((p) => p.x),
    [0, 1, 2, 3, 4],
  );
  for (const ray of raysDown(places, kWorld)) {
    assert.deepEqual(ray.direction, [0, -1, 0]);
    assert.ok(ray.origin[1] > 50 && ray.origin[1] - ray.maxT < 0);
  }
});

test('heights become facts and a table; what is not known stays empty', () => {
  const places = placesAlong([
    [0, 0, 0],
    [3, 0, 0],
  ]);
  const heights = [10, 14, undefined, 12];
  const hits = heights.map((y, i) => (y === undefined ? undefined : pickAt([i, y, 0], 41 - y, i)));
  const samples = makeSamples(places, hits, kWorld);
  const [north] = makeSamples([{ x: 4, z: -8, t: 0 }], [], kWorld);
  assert.match(toCsv([north!], { unitsPerVoxel: 0.5 }), /\r\n2\.000,4\.000,/);
  assert.deepEqual(toFacts(samples), {
    lengthM: 1.5,
    lowestM: 5,
    highestM: 7,
    ascentM: 2,
    descentM: 1,
    coarsestVoxelM: 4,
  });
  assert.deepEqual(toCsv(samples, { unitsPerVoxel: 0.5 }).split('\r\n'), [
    'easting,northing,distance_m,height_m,level_m',
    '0.000,0.000,0.000,5.000,0.5',
    '0.500,0.000,0.500,7.000,1',
    '1.000,0.000,1.000,,',
    '1.500,0.000,1.500,6.000,4',
    '',
  ]);
  assert.equal(toFacts(makeSamples(places, [], kWorld)), undefined);
});

test('a profile keeps its finest reading when the camera flies away', () => {
  const places = placesAlong([
    [0, 0, 0],
    [2, 0, 0],
  ]);
  const read = (levels: readonly (number | undefined)[]): ReturnType<typeof makeSamples> =>
    makeSamples(
      places,
      levels.map((level, i) =>
        level === undefined ? undefined : pickAt([i, 10 + level, 0], 1, level),
      ),
      kWorld,
    );
  const kept = finest(read([0, 3, undefined]), read([2, 1, 4]));
  assert.deepEqual(
    kept.map((s) => s.heightM),
    [5, 5.5, 7],
  );
  assert.deepEqual(
    finest(read([0, 0, 0]), read([undefined, 0, 0])).map((s) => s.heightM),
    [5, 5, 5],
  );
  assert.equal(finest(read([0, 0, 0]).slice(1), read([2, 2, 2]))[0]!.heightM, 6, 'another line');
});

test('ticks are round and inside the range', () => {
  assert.deepEqual(chooseTicks(0, 10, 5), [0, 2, 4, 6, 8, 10]);
  assert.deepEqual(chooseTicks(471.2, 486.3, 4), [475, 480, 485]);
  assert.deepEqual(chooseTicks(0, 0.3, 3), [0, 0.1, 0.2, 0.3]);
  assert.deepEqual(chooseTicks(5, 5, 4), [5]);
  const random = makeShare(8);
  for (let i = 0; i < 300; ++i) {
    const from = (random() - 0.5) * 1e4;
    const to = from + 10 ** (random() * 8 - 3);
    const ticks = chooseTicks(from, to, 5);
    assert.ok(ticks.length <= 7, `${from} to ${to}: ${ticks.length}`);
    for (const tick of ticks) assert.ok(tick >= from - 1e-6 && tick <= to + 1e-6, `${tick}`);
  }
});

test('keys move along a chart and stop at its ends', () => {
  const cases: readonly (readonly [string, number, number | undefined])[] = [
    ['ArrowRight', 3, 4],
    ['ArrowLeft', 0, 0],
    ['ArrowUp', 9, 9],
    ['PageDown', 4, 0],
    ['PageUp', 4, 9],
    ['Home', 4, 0],
    ['End', 4, 9],
    ['Tab', 4, undefined],
  ];
  for (const [key, at, wanted] of cases) assert.equal(keyTarget(key, at, 9), wanted, key);
});

// --- Section plane

const kNoPlane: SectionPlane = {
  kind: 'off',
  azimuthDeg: 0,
  position: 0,
  height: 20,
  isFlipped: false,
};

test('an upright plane cuts away what lies towards its azimuth', () => {
  const pivot: Vec3 = [100, 20, -200];
  const plane: SectionPlane = { ...kNoPlane, kind: 'vertical', azimuthDeg: 90, position: 5 };
  const isCut = (section: ReturnType<typeof toSection>, p: Vec3): boolean =>
    section!.normal.reduce((sum, n, a) => sum + n * p[a]!, 0) > section!.offset;
  const section = toSection(plane, pivot);
  assert.equal(isCut(section, [106, 0, -200]), true);
  assert.equal(isCut(section, [104, 0, -200]), false);
  const flipped = toSection({ ...plane, isFlipped: true }, pivot);
  assert.equal(isCut(flipped, [106, 0, -200]), false);
  assert.equal(isCut(flipped, [104, 0, -200]), true);
  isNear(Math.hypot(...section!.normal), 1);
  const level: SectionPlane = { ...kNoPlane, kind: 'horizontal', height: 30 };
  assert.deepEqual(toSection(level, pivot), { normal: [0, 1, 0], offset: 30 });
  assert.deepEqual(toSection({ ...level, isFlipped: true }, pivot), {
    normal: [0, -1, 0],
    offset: -30,
  });
  assert.equal(toSection(kNoPlane, pivot), undefined);
});

test('a plane can be put through a point', () => {
  const pivot: Vec3 = [100, 20, -200];
  const point: Vec3 = [130, 44, -250];
  const plane = through({ ...kNoPlane, kind: 'vertical', azimuthDeg: 33 }, pivot, point);
  const section = toSection(plane, pivot)!;
  isNear(section.normal[0] * point[0] + section.normal[2] * point[2], section.offset);
  assert.equal(plane.height, 44);
});

test('a plane survives its link, and wrong words are no plane', () => {
  for (const plane of [
    { ...kNoPlane, kind: 'vertical', azimuthDeg: 215, position: -69.67, isFlipped: true },
    { ...kNoPlane, kind: 'horizontal', height: 480.5 },
  ] as const) {
    assert.deepEqual(readSection(sectionWord(plane), kNoPlane), plane);
  }
  for (const bad of [
    null,
    '',
    'v',
    'v,',
    'v,1,2',
    'v,400,0,0',
    'h,1',
    'h,1,7',
    'x,1,2',
    'h,1e30,0',
  ]) {
    assert.equal(readSection(bad, kNoPlane), kNoPlane, String(bad));
  }
});

// --- Line of sight

test('a target is seen unless something lies before its own voxel', () => {
  const ray = sightRay([0, 0, 0], [0, 0, -100])!;
  assert.deepEqual(ray, { origin: [0, 0, 0], direction: [0, 0, -1], maxT: 100 });
  assert.equal(toSight(ray, undefined).obstacle, undefined);
  assert.equal(toSight(ray, pickAt([0, 0, -99], 99)).obstacle, undefined, 'its own voxel');
  assert.equal(toSight(ray, pickAt([0, 0, -94], 94, 2)).obstacle, undefined, 'a coarse one');
  const blocked = toSight(ray, pickAt([0, 0, -60], 60));
  assert.deepEqual(blocked.obstacle, [0, 0, -60]);
  assert.equal(blocked.obstacleDistance, 60);
  assert.equal(sightRay([1, 2, 3], [1, 2, 3]), undefined);
});
