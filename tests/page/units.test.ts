import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Api, toMessage, toTrouble } from '../../voxelserver/serve/page/src/http/api.js';
import type { Fetch } from '../../voxelserver/serve/page/src/http/environment.js';
import {
  decimalsFor,
  parsePlace,
  placeFromHash,
  placeToHash,
} from '../../voxelserver/serve/page/src/coordinates.js';
import {
  formatBytes,
  formatDuration,
  formatSeconds,
} from '../../voxelserver/serve/page/src/number-format.js';
import { Poller } from '../../voxelserver/serve/page/src/http/poller.js';
import { readStats, readWorld } from '../../voxelserver/serve/page/src/replies.js';
import {
  readCachedBoxes,
  readSquares,
  squareContains,
} from '../../voxelserver/serve/page/src/squares.js';
import {
  fileName,
  inTheMiddle,
  placeCamera,
  renderCommand,
  type Spot,
  viewLink,
  viewOfMap,
} from '../../voxelserver/serve/page/src/view-link.js';
import { computeForward } from '../../voxelserver/serve/page/src/viewer/ui/navigation.js';
import { fromLink, type ViewState } from '../../voxelserver/serve/page/src/viewer/ui/link.js';
import {
  horizontalWkt,
  WorldProjection,
} from '../../voxelserver/serve/page/src/world-projection.js';
import crsCases from './support/crs.json';
import { toHttp } from './support/fake-host.js';
import { kCrs, squaresJson, worldJson } from './support/fake-world.js';

const world = readWorld(worldJson('Synthetic hills'));
const projection = new WorldProjection(world);

// Coordinates by PROJ of one place in each CRS; a metre is more than the map needs.
for (const item of crsCases) {
  test(`latitude and longitude agree with PROJ in ${item.crs}`, () => {
    const [e, n] = [Math.floor(item.easting), Math.floor(-item.northing)];
    const here = new WorldProjection({
      ...world,
      crsWkt: item.wkt,
      crsProj4: item.proj4,
      min: [e, 0, n],
      max: [e + 1, 1, n + 1],
      centre: { ...item, convergenceDeg: 0 },
    });
    const found = here.toLatLon(item.easting, item.northing);
    assert.ok(found);
    const east = (found.lonDeg - item.lonDeg) * Math.cos((item.latDeg * Math.PI) / 180);
    assert.ok(
      Math.hypot(east, found.latDeg - item.latDeg) * 111_000 < 1,
      `${found.latDeg}, ${found.lonDeg} instead of ${item.latDeg}, ${item.lonDeg}`,
    );
    const back = here.fromLatLon(found);
    assert.ok(back && Math.hypot(back[0] - item.easting, back[1] - item.northing) < 0.01);
  });
}

test('clocks of analyses are those of the longitude of a small world, or a part', () => {
  const item = crsCases[0]!;
  const makeWorld = (halfM: number, lonDeg: number): WorldProjection =>
    new WorldProjection({
      ...world,
      crsWkt: item.wkt,
      crsProj4: item.proj4,
      min: [Math.floor(item.easting - halfM), 0, Math.floor(-item.northing - halfM)],
      max: [Math.floor(item.easting + halfM), 1, Math.floor(-item.northing + halfM)],
      centre: { ...item, lonDeg, convergenceDeg: 0 },
    });
  const part = [
    item.easting - 500,
    item.northing - 500,
    item.easting + 500,
    item.northing + 500,
  ] as const;
  const ofPart = Math.round(item.lonDeg / 15);
  assert.equal(makeWorld(9_000, -30.2).clockOffsetH(part), -2);
  assert.equal(makeWorld(15_000, item.lonDeg).clockOffsetH(part), ofPart);
  assert.equal(new WorldProjection({ ...world, centre: undefined }).clockOffsetH(part), undefined);
});

test('clocks of wide worlds are those of the middle of a square of 10 km, as on the server', () => {
  // On this globe a degree has 100 km, and clocks change 4 km and 6 km into squares.
  const makeWideWorld = (falseEasting: number): WorldProjection =>
    new WorldProjection({
      ...world,
      crsWkt: `+proj=eqc +R=5729577.951308232 +x_0=${falseEasting} +units=m +no_defs`,
      crsProj4: '',
      min: [-2_000_000, 0, -1_000_000],
      max: [2_000_000, 1, 1_000_000],
      centre: { latDeg: 0, lonDeg: -falseEasting / 100_000, convergenceDeg: 0 },
    });
  // The middle of the square is at 755 km.
  const cases = [
    [4_000, 751_000, 1],
    [4_000, 759_000, 1],
    [4_000, 749_000, 0],
    [6_000, 759_000, 0],
    [6_000, 761_000, 1],
    [6_000, -741_000, -1],
  ] as const;
  for (const [falseEasting, easting, hours] of cases) {
    assert.equal(
      makeWideWorld(falseEasting).clockOffsetH([easting - 100, 300, easting + 100, 500]),
      hours,
      `${falseEasting}, ${easting}`,
    );
  }
});

test('clocks without a CRS are those of the centre, halves away from zero', () => {
  const cases = [
    [-7.5, -1],
    [7.5, 1],
    [-7.4, 0],
    [-22.5, -2],
    [22.4, 1],
    [172.5, 12],
  ] as const;
  for (const [lonDeg, hours] of cases) {
    const here = new WorldProjection({
      ...world,
      crsWkt: '',
      crsProj4: '',
      min: [0, 0, 0],
      max: [50_000, 1, 50_000],
      centre: { latDeg: 0, lonDeg, convergenceDeg: 0 },
    });
    assert.equal(here.clockOffsetH([0, 0, 10, 10]), hours, `${lonDeg}`);
  }
});

test('a CRS that is not understood, or lies elsewhere, gives no latitude and longitude', () => {
  for (const [crsWkt, crsProj4] of [
    ['', ''],
    ['NONSENSE["x"]', '+proj=nonsense'],
    [crsCases[1]!.wkt, ''],
  ] as const) {
    const here = new WorldProjection({ ...world, crsWkt, crsProj4 });
    assert.equal(here.toLatLon(462500, 101500), undefined, crsWkt.slice(0, 40));
    assert.equal(here.fromLatLon({ latDeg: 46, lonDeg: 14.5 }), undefined);
  }
});

test('the horizontal part of a compound CRS ends with its bracket, those in names apart', () => {
  const inner = 'PROJCRS["a ] b",BASEGEOGCRS["c"],CONVERSION["[[d"]]';
  assert.equal(horizontalWkt(`COMPOUNDCRS["x",${inner},VERTCRS["h"]]`), inner);
  assert.equal(horizontalWkt(kCrs.wkt), kCrs.wkt);
  assert.equal(
    horizontalWkt('COMPOUNDCRS["x",PROJCRS["never closed"'),
    'COMPOUNDCRS["x",PROJCRS["never closed"',
  );
});

test('voxels, tiles and boxes lie where the interface defines', () => {
  assert.deepEqual(projection.extent, [462000, 101000, 463024, 102024]);
  assert.deepEqual(projection.toVoxel(462000.5, 101999.5), [462000, -102000]);
  assert.deepEqual(projection.boxExtent(0, 7218, -1595), [461952, 102016, 462016, 102080]);
  assert.deepEqual(projection.boxExtent(2, -1, -1), [-256, 0, 0, 256]);
  assert.equal(projection.resolution(5), 1);
  assert.equal(projection.resolution(0), 32);
  const feet = new WorldProjection({
    ...world,
    unitsPerVoxel: 3937 / 1200,
    crsWkt: '',
    crsProj4: '',
  });
  assert.ok(Math.abs(feet.metresPerUnit - 1200 / 3937) < 1e-12);
  assert.deepEqual(feet.toVoxel(-0.1, 0.1), [-1, -1]);
});

test('places are read as users write them', () => {
  const degrees = projection.toLatLon(462500, 101500)!;
  const near = (text: string): void => {
    const found = parsePlace(text, projection);
    if (typeof found === 'string') assert.fail(`${text}: ${found}`);
    assert.ok(
      Math.hypot(found.easting - 462500, found.northing - 101500) < 0.2,
      `${text}: ${found.easting}, ${found.northing}`,
    );
  };
  const [lat, lon] = [degrees.latDeg.toFixed(7), degrees.lonDeg.toFixed(7)];
  for (const text of ['462500,101500', ' 462500.0 ; 101500 ', '+462500 101500']) near(text);
  for (const text of [`${lat}, ${lon}`, `${lat}° N ${lon}° E`, `${lat}N,${lon}E`]) near(text);
  for (const text of ['', '1', '1 2 3', 'Bled', '1e3, 2', 'N 46', '91N 10E', '12,,x']) {
    assert.equal(typeof parsePlace(text, projection), 'string', text);
  }
  const south = parsePlace('10 S, 20 W', projection);
  assert.ok(typeof south !== 'string' && south.northing < 0);
});

test('a place survives its address', () => {
  assert.deepEqual(placeFromHash(placeToHash(462500.25, -101500.75, 1.5, 2)), {
    easting: 462500.25,
    northing: -101500.75,
    resolution: 1.5,
  });
  const nowhere = [
    '',
    '#',
    '#e=1&n=2',
    '#e=1&n=2&r=0',
    '#e=NaN&n=2&r=1',
    '#e=1e9&n=2&r=1',
    '#e=<b>&n=2&r=1',
  ];
  for (const bad of nowhere) assert.equal(placeFromHash(bad), undefined, bad);
  assert.deepEqual([0.25, 0.5, 1, 2, 10, 3.28, 1e-7].map(decimalsFor), [2, 2, 1, 1, 0, 1, 6]);
});

test('the render command stands 400 m south-west and 300 m above, and never in a hill', () => {
  const target = { easting: 462500, northing: 101500, heightM: 310 };
  const camera = placeCamera(target, projection);
  const { easting: e, northing: n } = camera;
  assert.ok(e < 462500 && n < 101500);
  assert.ok(Math.abs(Math.hypot(462500 - e, 101500 - n) - 400) < 1e-9);
  assert.equal(camera.heightM, 610);
  assert.equal(placeCamera(target, projection, 900).heightM, 960);
  const command = renderCommand('http://localhost:8080', target, camera, 'TM 462/101', projection);
  assert.equal(
    command,
    './terravox render http://localhost:8080 --camera-target=462500.0,101500.0,310.0 ' +
      '--camera-position=462217.2,101217.2,610.0 -o TM-462-101.png',
  );
});

test('no name or address can put a second command into the first', () => {
  for (const name of [
    '$(reboot)',
    '`reboot`',
    'a;b',
    "a'b",
    'a\nb',
    '../../etc/passwd',
    '-rf',
    '',
    '...',
    'č'.repeat(99),
  ]) {
    assert.match(fileName(name), /^[A-Za-z0-9_][A-Za-z0-9_.-]*$/, name);
  }
  const spot = { easting: 0, northing: 0, heightM: 0 };
  assert.match(
    renderCommand("http://h/a';b&$(c)", spot, spot, 'x', projection),
    /render 'http:\/\/h\/a'\\'';b&\$\(c\)' --camera/,
  );
});

test('links to the viewer are views of the place, from above the ground', () => {
  const otherwise: ViewState = {
    view: { position: [0, 0, 0], headingDeg: 1, pitchDeg: 2, fovDeg: 50 },
    timeMs: 60_000,
  };
  const place = { easting: 462500, northing: 101500 };
  const seen = (target: Spot): string =>
    viewLink(target, placeCamera(target, projection), projection);
  const links = {
    'a spot': seen({ ...place, heightM: 310 }),
    'a place of unknown height': seen(inTheMiddle(place, projection)),
    'the map, near': viewOfMap([place.easting, place.northing], 40, projection),
    'the map, whole': viewOfMap([place.easting, place.northing], 1000, projection),
  };
  for (const [name, link] of Object.entries(links)) {
    assert.ok(link.startsWith('view/#'), name);
    const { view, timeMs } = fromLink(link.slice('view/'.length), otherwise);
    assert.equal(timeMs, otherwise.timeMs, 'the time is left to the viewer');
    const forward = computeForward(view);
    // Where the line of sight passes above the place: it must pass right above it.
    const t = (-place.northing - view.position[2]) / forward[2];
    assert.ok(
      t > 0 && Math.abs(view.position[0] + t * forward[0] - place.easting) < 1,
      `${name}: ${link}`,
    );
    const height = view.position[1] + t * forward[1];
    assert.ok(Math.abs(height - (name === 'a spot' ? 310 : 420)) < 1, `${name}: ${height}`);
    assert.ok(view.position[1] > (name.startsWith('the map') ? 640 : 600), name);
  }
});

test('the map begins with what the world frames, or with all of it', () => {
  const good = worldJson('x') as Record<string, unknown>;
  const all = new WorldProjection(readWorld(good));
  assert.deepEqual(all.framedExtent, all.extent);
  const framed = { min: [-256, 0, -128], max: [512, 80, 64] };
  const endless = new WorldProjection(
    readWorld({ ...good, framed, crs: '', crs_wkt: '', crs_units_per_voxel: 2 }),
  );
  assert.deepEqual(endless.framedExtent, [-512, -128, 1024, 256]);
  assert.throws(() => readWorld({ ...good, framed: { min: [0], max: [1, 1, 1] } }), /framed.min/);
});

test('what flies far above a place is not among what is shown first', () => {
  const good = {
    ...(worldJson('x') as Record<string, unknown>),
    bounds: { min: [0, 0, 0], max: [64, 900, 64] },
  };
  const heights = (min: unknown, max: unknown): readonly number[] => {
    const { framed } = readWorld({ ...good, typical_heights: { min, max } });
    return [framed.min[1], framed.max[1]];
  };
  assert.deepEqual(heights(-5, 80), [0, 80]);
  assert.deepEqual(heights(20, 80), [20, 80]);
  assert.deepEqual(heights(900, 950), [0, 900]);
  assert.equal(readWorld({ ...good, typical_heights: { min: 20, max: 80 } }).max[1], 900);
  assert.throws(() => heights('0', 80), /typical_heights.min/);
});

test('replies are checked: what the map depends on must be there, the rest may be missing', () => {
  const good = worldJson('x') as Record<string, unknown>;
  const flat = { min: [0, 0], max: [1, 1, 1] };
  for (const [name, value] of [
    ['bounds', {}],
    ['voxel_m', 0],
    ['levels', 99],
    ['crs_units_per_voxel', '1'],
    ['bounds', flat],
  ] as const) {
    assert.throws(() => readWorld({ ...good, [name]: value }), /read the/, name);
  }
  assert.throws(() => readWorld([]));
  assert.equal(readWorld({ ...good, map: undefined }).finestZoom, -1);
  assert.deepEqual(readStats({}).stages, []);
  assert.equal(
    readStats({ requests: { a: { 200: 3, 404: 1 }, b: { 200: 2 }, c: null } }).requests,
    6,
  );
  assert.equal(readStats({ disk: null }).disk, undefined);
  assert.throws(() => readStats(null));
  assert.throws(() => readCachedBoxes({ memory: [] }));
  assert.deepEqual(
    readCachedBoxes({ level: 1, memory: [[1, 2, 3], [1, 2], 'x'], disk: null }).memory,
    [[1, 2, 3]],
  );
});

test('squares are found by place; one that is no polygon hides no other', () => {
  const json = squaresJson([
    { name: 'a', state: 'prepared' },
    { name: 'b', state: 'brand new' },
  ]) as { features: unknown[] };
  json.features.push(
    null,
    { type: 'Feature' },
    { geometry: { type: 'Point', coordinates: [1, 2] }, properties: {} },
  );
  const squares = readSquares(json);
  assert.deepEqual(
    squares.map(({ name, state }) => [name, state]),
    [
      ['a', 'prepared'],
      ['b', 'wanted'],
    ],
  );
  const at = (e: number, n: number): string | undefined =>
    squares.find((square) => squareContains(square, [e, n]))?.name;
  assert.deepEqual(
    [at(462001, 102000), at(462600, 101600), at(462001, 101000), at(461999, 102000)],
    ['a', 'b', undefined, undefined],
  );
  assert.throws(() => readSquares({ features: 1 }));
});

test('numbers read well', () => {
  assert.deepEqual([0, 1023, 1024, 1536, 2 ** 30, 200 * 2 ** 40].map(formatBytes), [
    '0 B',
    '1023 B',
    '1.0 KiB',
    '1.5 KiB',
    '1.0 GiB',
    '200 TiB',
  ]);
  assert.deepEqual([0, 0.0000004, 0.00091, 0.0634, 1.5, 250].map(formatSeconds), [
    '0.00 µs',
    '0.40 µs',
    '910 µs',
    '63.4 ms',
    '1.50 s',
    '250 s',
  ]);
  assert.deepEqual([5, 65, 3700, 90_000].map(formatDuration), [
    '5 s',
    '1 min 5 s',
    '1 h 1 min',
    '1 d 1 h',
  ]);
});

const emptyStore = { getItem: () => null, setItem: () => undefined, removeItem: () => undefined };

test('kinds of errors are distinguished, and the message of the server is kept', async () => {
  const cases = [
    [401, 'token'],
    [403, 'token'],
    [404, 'missing'],
    [429, 'busy'],
    [500, 'refused'],
    [502, 'gone'],
    [503, 'busy'],
  ] as const;
  for (const [status, trouble] of cases) {
    const api = new Api(
      'http://h/p/',
      toHttp(async () => Response.json({ title: 'T', detail: 'd <b>' }, { status })),
      emptyStore,
    );
    await assert.rejects(
      api.get('v2/stats'),
      (error: unknown) => toTrouble(error) === trouble && toMessage(error) === 'T: d <b>',
    );
  }
  const gone = new Api(
    'http://h/',
    toHttp(() => Promise.reject(new TypeError('refused'))),
    emptyStore,
  );
  await assert.rejects(gone.get('x'), (error: unknown) => toTrouble(error) === 'gone');
  const html = new Api(
    'http://h/',
    toHttp(async () => new Response('<html>')),
    emptyStore,
  );
  await assert.rejects(html.getJson('x'), /no JSON/);
});

test('requests stay below the path of the page and carry the token', async () => {
  const seen: [string, unknown][] = [];
  const fetch: Fetch = async (url, init) => {
    seen.push([url, init.headers]);
    return new Response('{}');
  };
  const kept = new Map<string, string>();
  const store = {
    getItem: (key: string) => kept.get(key) ?? null,
    setItem: (key: string, value: string) => void kept.set(key, value),
    removeItem: (key: string) => void kept.delete(key),
  };
  const api = new Api('https://host/terravox/index.html#e=1', toHttp(fetch), store);
  await (await api.get('v2/world')).bytes();
  api.setToken('secret');
  await (await api.get('map/0/-1/-2.png')).bytes();
  assert.deepEqual(seen, [
    ['https://host/terravox/v2/world', {}],
    ['https://host/terravox/map/0/-1/-2.png', { Authorization: 'Bearer secret' }],
  ]);
});

test('a poll waits longer after failures, runs once, rests while the tab is hidden', async () => {
  const timers: { ms: number; run: () => void }[] = [];
  let [runs, paused, fails] = [0, false, true];
  const settle = (): Promise<void> => new Promise((resolve) => setImmediate(resolve));
  const job = async (): Promise<void> => {
    ++runs;
    if (fails) throw new Error('no');
  };
  const poller = new Poller(1000, job, {
    after: (ms, run) => void timers.push({ ms, run }),
    isPaused: () => paused,
  });
  poller.wake();
  poller.wake();
  await settle();
  assert.equal(runs, 1);
  for (let i = 0; i < 12; ++i) {
    timers.at(-1)!.run();
    await settle();
  }
  assert.deepEqual([timers[0]!.ms, timers[1]!.ms, timers.at(-1)!.ms], [2000, 3000, 10_000]);
  fails = false;
  poller.wake();
  await settle();
  assert.equal(timers.at(-1)!.ms, 1000);
  const before = runs;
  timers[0]!.run(); // overtaken by wake()
  paused = true;
  timers.at(-1)!.run();
  await settle();
  assert.equal(runs, before);
});
