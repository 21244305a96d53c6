import assert from 'node:assert/strict';
import { test } from 'node:test';
import { toHttp } from './support/fake-host.js';
import {
  hashColumn,
  makeColumnTable,
  type CutColumn,
} from '../../voxelserver/serve/page/src/viewer/draw/column-table.js';
import type { Appearance } from '../../voxelserver/serve/page/src/viewer/draw/appearance.js';
import { fromHalf } from '../../voxelserver/serve/page/src/bytes.js';
import {
  contourStepM,
  heightColour,
  kLayerColours,
  kOtherClass,
  layerTable,
  makeLegend,
} from '../../voxelserver/serve/page/src/viewer/draw/layers.js';
import { LevelCut } from '../../voxelserver/serve/page/src/viewer/draw/level-cut.js';
import {
  checkLook,
  kDefaultLook,
  type Look,
} from '../../voxelserver/serve/page/src/viewer/draw/look.js';
import { Pace } from '../../voxelserver/serve/page/src/viewer/passes.js';
import type { ColumnKey } from '../../voxelserver/serve/page/src/viewer/data/columns.js';
import { Residency } from '../../voxelserver/serve/page/src/viewer/draw/residency.js';
import { RowPool } from '../../voxelserver/serve/page/src/viewer/draw/row-pool.js';
import { wavePhases } from '../../voxelserver/serve/page/src/viewer/draw/waves.js';
import { sunPosition } from '../../voxelserver/serve/page/src/viewer/draw/sun-position.js';
import { fromLink, toLink } from '../../voxelserver/serve/page/src/viewer/ui/link.js';
import {
  toCamera,
  lookingAt,
  orbited,
  turned,
  type Viewpoint,
} from '../../voxelserver/serve/page/src/viewer/ui/navigation.js';
import { kTokenKey } from '../../voxelserver/serve/page/src/http/api.js';
import { readStats, readWorld } from '../../voxelserver/serve/page/src/replies.js';
import { readPlaceFile } from '../../voxelserver/serve/page/src/viewer/ui/place-file.js';
import { tokenStore } from '../../voxelserver/serve/page/src/token.js';
import {
  fetchWithToken,
  serverPlace,
} from '../../voxelserver/serve/page/src/viewer/ui/server-access.js';
import {
  placeOnMap,
  describeProgress,
} from '../../voxelserver/serve/page/src/viewer/ui/server-watch.js';
import { text } from '../../voxelserver/serve/page/src/viewer/ui/texts.js';
import { makeShare } from './support/test-bytes.js';

test('rows that are freed can be taken again, and no two runs overlap', () => {
  const random = makeShare(1);
  const pool = new RowPool(192);
  const taken: { at: number; rows: number }[] = [];
  for (let i = 0; i < 1000; ++i) {
    if (random() < 0.55) {
      const rows = 1 + Math.floor(random() * 20);
      const at = pool.take(rows);
      if (at === undefined) continue;
      assert.ok(at >= 0 && at + rows <= pool.capacity);
      for (const other of taken) {
        assert.ok(at + rows <= other.at || other.at + other.rows <= at, 'runs do not overlap');
      }
      taken.push({ at, rows });
    } else if (taken.length > 0) {
      const [gone] = taken.splice(Math.floor(random() * taken.length), 1);
      pool.free(gone!.at, gone!.rows);
    }
    assert.equal(
      pool.used,
      taken.reduce((sum, run) => sum + run.rows, 0),
    );
  }
  for (const run of taken) pool.free(run.at, run.rows);
  assert.equal(pool.take(pool.capacity), 0, 'what was freed has been joined');
});

test('each column is found where the shader looks for it', () => {
  const random = makeShare(2);
  const cut: CutColumn[] = [];
  for (let i = 0; i < 3000; ++i) {
    const key = { level: i % 7, bx: Math.floor(random() * 900) - 450, bz: i - 1500 };
    const boxes =
      i % 3 === 0
        ? undefined
        : {
            byBegin: -2,
            slots: [{ kind: 'air' }, { kind: 'box', cells: i, attributes: 2 * i }] as const,
          };
    cut.push({ ...key, boxes });
  }
  const { columns, mask, boxes } = makeColumnTable(cut);
  assert.equal(boxes.length % 4096, 0);
  for (const [i, column] of cut.entries()) {
    let at = hashColumn(column.bx, column.bz, column.level) & mask;
    let probes = 0;
    while (!(
      columns[at * 4] === column.bx >>> 0 &&
      columns[at * 4 + 1] === column.bz >>> 0 &&
      (columns[at * 4 + 2]! & 31) === column.level
    )) {
      probes += 1;
      assert.ok(columns[at * 4 + 2] !== 0 && probes < 64, 'an empty entry or too many probes');
      at = (at + 1) & mask;
    }
    assert.equal(columns[at * 4 + 2]! >> 8, column.boxes === undefined ? 2 : 1);
    if (column.boxes === undefined) continue;
    const base = columns[at * 4 + 3]! * 4;
    assert.deepEqual([boxes[base]! | 0, boxes[base + 1]], [-2, 2]);
    assert.deepEqual([...boxes.slice(base + 8, base + 11)], [1, i, 2 * i]);
  }
});

const kBounds = { min: [-300, 0, -300], max: [1700, 200, 1500] } as const;
const kStored = { byBegin: 0, slots: [] };
const cutAt = (eye: readonly [number, number, number], detail = 1): LevelCut =>
  new LevelCut(kBounds, { eye, pixelRad: 0.004, detail }, 5);

test('where a column is far enough, so are its halves', () => {
  const random = makeShare(3);
  for (let i = 0; i < 2000; ++i) {
    const cut = cutAt([random() * 3000 - 500, random() * 900, random() * 3000 - 500]);
    const level = 1 + Math.floor(random() * 5);
    const [bx, bz] = [Math.floor(random() * 8) - 2, Math.floor(random() * 8) - 2];
    if (!cut.isFarEnough(level, bx, bz)) continue;
    for (const [x, z] of [
      [0, 0],
      [1, 0],
      [0, 1],
      [1, 1],
    ] as const) {
      assert.ok(cut.isFarEnough(level - 1, bx * 2 + x, bz * 2 + z));
    }
  }
});

test('there is as much detail around an observer as around the eye', () => {
  const random = makeShare(5);
  for (let i = 0; i < 500; ++i) {
    const eye = [random() * 3000 - 500, random() * 900, random() * 3000 - 500] as const;
    const observer = [random() * 3000 - 500, random() * 300, random() * 3000 - 500] as const;
    const [one, other] = [cutAt(eye), cutAt(observer)];
    const both = new LevelCut(kBounds, { eye, observer, pixelRad: 0.004, detail: 1 }, 5);
    const level = 1 + Math.floor(random() * 5);
    const [bx, bz] = [Math.floor(random() * 8) - 2, Math.floor(random() * 8) - 2];
    assert.equal(
      both.isFarEnough(level, bx, bz),
      one.isFarEnough(level, bx, bz) && other.isFarEnough(level, bx, bz),
    );
  }
});

test('what is shown covers each place once, whatever is there, and is the cut in the end', () => {
  const random = makeShare(4);
  const cut = cutAt([400, 300, 400]);
  const residency = new Residency({ drop: () => {} });
  let plan = residency.plan(cut, () => true);
  let rounds = 0;
  while (!plan.isComplete) {
    rounds += 1;
    assert.ok(rounds < 500);
    // Columns arrive in any order.
    const some = plan.wanted.filter(() => random() < 0.3);
    for (const key of some) residency.add(key, kStored);
    plan = residency.plan(cut, () => true);
    const leaves = plan.shown.filter((column) => column.boxes !== undefined);
    for (let i = 0; i < 50 && leaves.length > 0; ++i) {
      const [x, z] = [-290 + random() * 1900, -290 + random() * 1700];
      const over = leaves.filter(({ level, bx, bz }) => {
        const side = 64 * 2 ** level;
        return Math.floor(x / side) === bx && Math.floor(z / side) === bz;
      });
      const roots = plan.wanted.filter((key) => key.level === cut.coarsest).length;
      assert.ok(
        over.length === 1 || (over.length === 0 && roots > 0),
        `${over.length} leaves at a place`,
      );
    }
  }
  for (const column of plan.shown) {
    assert.equal(column.boxes !== undefined, cut.isFarEnough(column.level, column.bx, column.bz));
  }
  assert.deepEqual(plan.wanted, []);
});

test('wanted columns come coarse first, then those in view; what a plan needs stays', () => {
  const cut = cutAt([400, 300, 400]);
  let dropped = 0;
  const residency = new Residency({ drop: () => void (dropped += 1) });
  const ahead = (key: ColumnKey): boolean => key.bx % 2 === 0;
  const { wanted } = residency.plan(cut, ahead);
  for (let i = 1; i < wanted.length; ++i) {
    const [a, b] = [wanted[i - 1]!, wanted[i]!];
    assert.ok(a.level >= b.level);
    if (a.level === b.level) assert.ok(ahead(a) || !ahead(b));
  }
  const stranger = { level: 0, bx: 99, bz: 99 };
  residency.add(stranger, kStored);
  for (const key of wanted) residency.add(key, kStored);
  residency.plan(cut, ahead);
  assert.equal(residency.dropOldest(), true);
  assert.equal(residency.has(stranger), false);
  assert.equal(residency.dropOldest(), false, 'all others are part of the plan');
  assert.equal(dropped, 1);
});

test('a slow processor gets fewer pixels while the picture moves, and never none', () => {
  const pace = new Pace();
  for (let i = 0; i < 50; ++i) pace.learn(1000, 100);
  const [width, height] = pace.movingSize([1920, 1080]);
  assert.ok(width >= 300 && width < 500 && height >= 170, `${width} x ${height}`);
  assert.ok(pace.bandRows(1920) >= 8);
  for (let i = 0; i < 200; ++i) pace.learn(1e7, 1);
  assert.deepEqual(pace.movingSize([1920, 1080]), [1920, 1080]);
});

test('the sun stands where the program places it', () => {
  // By common/geo/sun_position.cpp, for the demo's place.
  const timeMs = Date.UTC(2026, 5, 21, 15, 30);
  const place = { latDeg: 46.05226709929544, lonDeg: 14.515394664860125, convergenceDeg: 0 };
  const { altitudeDeg, azimuthDeg } = sunPosition(timeMs, place);
  assert.ok(Math.abs(altitudeDeg - 32.6937) < 1e-3, String(altitudeDeg));
  assert.ok(Math.abs(azimuthDeg - 270.8952) < 1e-3, String(azimuthDeg));
  // A map whose north lies west of true north has everything further clockwise.
  const turned = sunPosition(timeMs, { ...place, convergenceDeg: -0.349 });
  assert.ok(Math.abs(turned.azimuthDeg - 271.2442) < 1e-3, String(turned.azimuthDeg));
  assert.equal(turned.altitudeDeg, altitudeDeg);
});

test('waves have the same phases wherever the eye is', () => {
  const at = wavePhases(5_100_000, -460_000);
  const beside = wavePhases(5_100_001, -460_000);
  for (const [i, perX] of [0.0713, 0.1319].entries()) {
    assert.ok(Math.abs(((beside.waves[i]! - at.waves[i]! + 1) % 1) - perX) < 1e-6);
  }
  assert.ok([...at.waves, ...at.ruffled].every((v) => v >= 0 && v < 1));
});

test('halves are read as they were written', () => {
  for (const [half, value] of [
    [0, 0],
    [0x3c00, 1],
    [0xc000, -2],
    [0x7bff, 65504],
    [1, 2 ** -24],
  ] as const) {
    assert.equal(fromHalf(half), value);
  }
});

type Bytes = readonly [number, number, number];

// Of red, green and blue in people who lack a kind of cone. Ref: Machado, Oliveira and Fernandes,
// "A Physiologically-based Model for Simulation of Color Vision Deficiency", 2009.
const kEyes = {
  all: [1, 0, 0, 0, 1, 0, 0, 0, 1],
  noRed: [
    0.152286, 1.052583, -0.204868, 0.114503, 0.786281, 0.099216, -0.003882, -0.048116, 1.051998,
  ],
  noGreen: [
    0.367322, 0.860646, -0.227968, 0.280085, 0.672501, 0.047413, -0.01182, 0.04294, 0.968881,
  ],
  noBlue: [
    1.255528, -0.076749, -0.178779, -0.078411, 0.930809, 0.147602, 0.004733, 0.691367, 0.3039,
  ],
} as const;

/** A colour as such an eye sees it, in OKLab, where distances are those that people see. */
function seenBy(eye: keyof typeof kEyes, colour: Bytes): number[] {
  const lit = colour.map((c) => (c <= 10 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4));
  const m = kEyes[eye];
  const rgb = [0, 3, 6].map((row) =>
    Math.max(0, m[row]! * lit[0]! + m[row + 1]! * lit[1]! + m[row + 2]! * lit[2]!),
  );
  const mixed = (r: number, g: number, b: number): number =>
    Math.cbrt(r * rgb[0]! + g * rgb[1]! + b * rgb[2]!);
  const l = mixed(0.4122214708, 0.5363325363, 0.0514459929);
  const n = mixed(0.2119034982, 0.6806995451, 0.1073969566);
  const s = mixed(0.0883024619, 0.2817188376, 0.6299787005);
  return [
    0.2104542553 * l + 0.793617785 * n - 0.0040720468 * s,
    1.9779984951 * l - 2.428592205 * n + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * n - 0.808675766 * s,
  ];
}

function apart(eye: keyof typeof kEyes, a: Bytes, b: Bytes): number {
  const other = seenBy(eye, b);
  return Math.hypot(...seenBy(eye, a).map((v, i) => v - other[i]!));
}

test('heights have even steps, and ascend for every eye', () => {
  const ramp = Array.from({ length: 21 }, (_, i) => heightColour(i / 20));
  const steps = ramp.slice(1).map((colour, i) => apart('all', colour, ramp[i]!));
  const mean = steps.reduce((sum, step) => sum + step, 0) / steps.length;
  for (const step of steps) assert.ok(Math.abs(step / mean - 1) < 0.15, `${step} of ${mean}`);
  for (const eye of ['all', 'noRed', 'noGreen', 'noBlue'] as const) {
    for (let i = 1; i < ramp.length; ++i) {
      assert.ok(seenBy(eye, ramp[i]!)[0]! > seenBy(eye, ramp[i - 1]!)[0]!, `${eye}: step ${i}`);
      assert.ok(apart(eye, ramp[i]!, ramp[i - 1]!) > 0.4 * mean, `${eye}: step ${i}`);
    }
  }
  assert.deepEqual([1, 16, 17, 33, 100, 1600].map(contourStepM), [0.1, 1, 2, 5, 10, 100]);
  assert.deepEqual(heightColour(-5), heightColour(0));
  assert.deepEqual(heightColour(7), heightColour(1));
});

const kNames = ['air', 'rock', 'ground', 'grass', 'high_vegetation', 'roof', 'water', 'my_own'];
const kLooks = {
  materials: kNames.map((name) => ({ name, colour: [1, 0.2, 0] })),
} as unknown as Appearance;

test('a legend tells its colours apart, and is what the shader draws', () => {
  const classes = makeLegend('class', kLooks, 0.5, 6);
  assert.equal(classes.find(({ of }) => of === 2)!.colour.join(), '201,169,122');
  const distinct = [...new Map(classes.map(({ colour }) => [colour.join(), colour])).values()];
  assert.ok(distinct.length >= 15);
  for (const eye of ['all', 'noRed', 'noGreen', 'noBlue'] as const) {
    for (const [i, a] of distinct.entries()) {
      for (const b of distinct.slice(0, i)) {
        assert.ok(apart(eye, a, b) > 0.04, `${eye}: ${a.join()} and ${b.join()}`);
      }
    }
  }

  const bytesAt = (table: Float32Array, i: number): number[] =>
    [0, 1, 2].map((a) => {
      const c = table[4 * i + a]!;
      return Math.round(255 * (c <= 0.0031308 ? c * 12.92 : 1.055 * c ** (1 / 2.4) - 0.055));
    });
  const table = layerTable('class', kLooks, 6);
  assert.equal(table.length, 4 * kLayerColours);
  for (const { of: number, colour } of classes) {
    const place = number === kOtherClass ? 200 : Number(number);
    assert.deepEqual(bytesAt(table, place), [...colour], String(number));
  }
  const materials = makeLegend('material', kLooks, 0.5, 6);
  assert.deepEqual(
    materials.map(({ of }) => of),
    kNames.slice(1),
  );
  for (const [i, { colour }] of materials.entries()) {
    assert.deepEqual(bytesAt(layerTable('material', kLooks, 6), i + 1), [...colour]);
  }
  assert.deepEqual(materials.at(-1)!.colour, [255, 124, 0], 'one that is not known has its own');

  const levels = makeLegend('level', kLooks, 0.5, 4);
  assert.deepEqual(
    levels.map(({ of }) => of),
    [0.5, 1, 2, 4],
  );
  for (const [i, { colour }] of levels.entries()) {
    assert.deepEqual(bytesAt(layerTable('level', kLooks, 4), i), [...colour]);
  }
  assert.equal(makeLegend('level', kLooks, 0.5, 1).length, 1);
  for (const layer of ['none', 'height'] as const) {
    assert.deepEqual(makeLegend(layer, kLooks, 0.5, 6), []);
  }
  assert.deepEqual(bytesAt(layerTable('height', kLooks, 6), 128), [...heightColour(0.5)]);
});

test('a look that cannot be drawn is refused with the name of what is wrong', () => {
  checkLook(kDefaultLook);
  checkLook({
    ...kDefaultLook,
    observer: [1, 2, 3],
    section: { normal: [0, 0.6, 0.8], offset: 5 },
  });
  const wrong: readonly (readonly [Partial<Look>, RegExp])[] = [
    [{ heightRange: [5, 5] }, /heightRange = 5, 5/],
    [{ heightRange: [0, NaN] }, /heightRange/],
    [{ observer: [0, Infinity, 0] }, /observer = 0, Infinity, 0/],
    [{ section: { normal: [1, 1, 0], offset: 0 } }, /section.normal = 1, 1, 0/],
    [{ section: { normal: [NaN, 1, 0], offset: 0 } }, /section.normal/],
    [{ section: { normal: [1, 0, 0], offset: 1e300 } }, /section.offset/],
  ];
  for (const [change, said] of wrong) {
    assert.throws(() => checkLook({ ...kDefaultLook, ...change }), said);
  }
});

const kView: Viewpoint = { position: [10, 20, -30], headingDeg: 40, pitchDeg: -10, fovDeg: 42 };

test('a link shows what was seen, and a wrong one changes nothing', () => {
  const state = { view: kView, timeMs: Date.UTC(2026, 5, 21, 15, 30) };
  const other = { view: { ...kView, position: [0, 0, 0] as const }, timeMs: 0 };
  assert.deepEqual(fromLink(toLink(state), other), state);
  const wrong =
    ' # #at=1,2 #at=1,2,x #at=1,2,1e99 #look=400,0,42 #look=1,2 #time=-1 #time=NaN #at=,,';
  for (const bad of wrong.split(' ')) assert.deepEqual(fromLink(bad, other), other, bad);
});

test('orbiting keeps the distance to what it turns around, and its place in the picture', () => {
  const centre = [100, -40, -200] as const;
  const before = lookingAt(kView, centre);
  const after = orbited(before, centre, 37, 12);
  const distance = (view: Viewpoint): number =>
    Math.hypot(...[0, 1, 2].map((a) => view.position[a]! - centre[a]!));
  assert.ok(Math.abs(distance(after) - distance(before)) < 1e-6);
  const camera = toCamera(after);
  const seen = [0, 1, 2].map((a) => after.position[a]! + camera.forward[a]! * distance(after));
  assert.ok(Math.hypot(...[0, 1, 2].map((a) => seen[a]! - centre[a]!)) < 1e-6);
  assert.equal(turned(kView, 720, 500).pitchDeg, 89.9);
  assert.equal(lookingAt(kView, [10, -500, -30]).headingDeg, 0, 'straight down, north is up');
});

const kPlace = {
  version: 1,
  title: 'A',
  attribution: '',
  licence: '',
  archive: { url: 'place.tvx' },
  views: [{ name: 'Start', position: [0, 1, 2], target: [3, 4, 5], fov_deg: 40 }],
  time_ms: 0,
};

test('place.json is refused with the name of what is wrong', () => {
  assert.equal(readPlaceFile(kPlace).views.length, 1);
  const parts = { ...kPlace, archive: { parts: [{ url: 'a', bytes: 5 }] } };
  assert.deepEqual(readPlaceFile(parts).archive, { parts: [{ url: 'a', bytes: 5 }] });
  const server = { server: '../', coarsest: 2 };
  assert.deepEqual(readPlaceFile({ ...kPlace, archive: server }).archive, server);
  assert.equal(readPlaceFile(kPlace).squares, undefined);
  assert.equal(readPlaceFile({ ...kPlace, squares: 'squares.json' }).squares, 'squares.json');
  const framed = (frame: unknown): object => ({ views: [{ ...kPlace.views[0], frame }] });
  const frame = { min: [0, -5, 0], max: [9, 9, 9] };
  assert.equal(readPlaceFile(kPlace).views[0]!.frame, undefined);
  assert.deepEqual(readPlaceFile({ ...kPlace, ...framed(frame) }).views[0]!.frame, frame);
  const wrong: readonly (readonly [object, RegExp])[] = [
    [{ version: 2 }, /version/],
    [{ title: 5 }, /title/],
    [{ archive: {} }, /archive.url/],
    [{ archive: { parts: [{ url: 'a', bytes: -1 }] } }, /bytes/],
    [{ archive: { server: 5, coarsest: 2 } }, /archive.server/],
    [{ archive: { server: '../' } }, /archive.coarsest/],
    [{ archive: { server: '../', coarsest: 21 } }, /archive.coarsest/],
    [{ archive: { server: '../', coarsest: 1.5 } }, /archive.coarsest/],
    [{ views: [] }, /no view/],
    [{ views: [{ ...kPlace.views[0], position: [0, 1] }] }, /position/],
    [{ views: [{ ...kPlace.views[0], fov_deg: 1000 }] }, /fov_deg/],
    [framed(5), /frame is no object/],
    [framed({ min: [0, 0, 0] }), /max/],
    [framed({ min: [0, 0, 0], max: [9, 0, 9] }), /a frame is empty/],
    [framed({ min: [0, 0, -1e10], max: [9, 9, 9] }), /min/],
    [{ time_ms: -5 }, /time_ms/],
    [{ squares: 5 }, /squares/],
  ];
  for (const [change, said] of wrong) {
    assert.throws(() => readPlaceFile({ ...kPlace, ...change }), said);
  }
  for (const bad of [null, 5, [], 'x']) assert.throws(() => readPlaceFile(bad), /no object/);
});

test("the token goes to the page's own origin, and to no other", async () => {
  const sent: string[] = [];
  const own = { origin: 'https://own.example' };
  const before = { location: globalThis.location };
  Object.assign(globalThis, { location: own });
  const http = toHttp(async (url, init) => {
    const { host, origin } = new URL(url);
    sent.push(`${host} ${new Headers(init.headers).get('Authorization') ?? 'nothing'}`);
    const challenge = { status: 401, headers: { 'WWW-Authenticate': 'Bearer' } };
    return new Response('', origin === own.origin ? {} : challenge);
  });
  try {
    tokenStore.setItem(kTokenKey, 's3cret');
    const say = (): string => '';
    assert.equal(
      (await fetchWithToken(http, new URL('https://own.example/a'), 'a', say)).status,
      200,
    );
    assert.equal(
      (await fetchWithToken(http, new URL('https://other.example/a'), 'a', say)).status,
      401,
    );
    assert.deepEqual(sent, ['own.example Bearer s3cret', 'other.example nothing']);
    const server = 'https://own.example/path/';
    assert.deepEqual(serverPlace(server, 2), { server, coarsest: 2, token: 's3cret' });
    for (const other of [
      'https://other.example/',
      'http://own.example/',
      'https://own.example:1/',
    ]) {
      assert.throws(() => serverPlace(other, 2), /another origin/);
    }
    tokenStore.removeItem(kTokenKey);
    assert.deepEqual(serverPlace(server, 2), { server, coarsest: 2 });
  } finally {
    Object.assign(globalThis, before);
  }
});

test('the map shows what is looked at, or what is under the camera', () => {
  const bounds = { min: [0, 0, 0], max: [4000, 200, 4000] } as const;
  const world = readWorld({
    bounds,
    voxel_m: 0.5,
    levels: 3,
    crs_units_per_voxel: 0.5,
  });
  const view = { position: [1000, 400, -2000], headingDeg: 90, pitchDeg: -45, fovDeg: 45 } as const;
  assert.equal(placeOnMap(view, world), '#e=650.00&n=1000.00&r=0.414');
  for (const pitchDeg of [0, 30, -1]) {
    assert.equal(placeOnMap({ ...view, pitchDeg }, world), '#e=500.00&n=1000.00&r=0.195');
  }
});

test('a server that makes boxes says how far it is, and one that makes none says nothing', () => {
  const said = (making: object, prepare?: object): string =>
    describeProgress(readStats({ making, prepare }), (key, ...values) =>
      text('en', key, ...values),
    );
  assert.equal(said({ made: 70 }), '');
  assert.match(said({ running: 2, waiting: 5, made: 70 }), /: 2 now, 5 waiting, 70 made$/);
  assert.match(said({}, { done: 3, total: 9 }), /3 of 9/);
  assert.equal(said({}, { done: 9, total: 9 }), '');
  assert.match(said({ made: 1, failed: 4 }), /^4 could not be made/);
});
