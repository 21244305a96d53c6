import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { test, type TestContext } from 'node:test';
import {
  editDistance,
  measureExtent,
  findArea,
  folded,
  loadAreas,
} from '../../../grabber/src/select/areas.js';
import { regionOfPolygons } from '../../../grabber/src/select/region.js';
import {
  select,
  type Selection,
  type SelectionOptions,
} from '../../../grabber/src/select/selection.js';
import { loadSources } from '../../../grabber/src/sources/source.js';
import { readPackageInfo } from '../../../grabber/src/util/package-info.js';
import { clientFor, found } from '../support/catalogue-fixture.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

const kConfig = join(readPackageInfo().root, '..', 'config');
const kAreas = join(kConfig, 'areas');
const shipped = loadSources(join(kConfig, 'sources'), kNever);

async function chosen(t: TestContext, options: SelectionOptions): Promise<Selection> {
  return select({ areasFolder: kAreas, ...options }, await shipped, clientFor(t), kNever);
}

async function names(t: TestContext, options: SelectionOptions): Promise<string[]> {
  const { catalogue, region } = await chosen(t, options);
  return (await found(catalogue, region)).map(({ name }) => name);
}

test('every shipped area lies in a source, and is of a size to fetch', async () => {
  const areas = await loadAreas(kAreas, kNever);
  const sources = await shipped;
  const where: Record<string, string> = {
    autzen: 'us-3dep',
    delft: 'nl-ahn',
    fuessen: 'de-by',
    koeln: 'de-nw',
    matterhorn: 'ch-swisstopo',
    montpellier: 'fr-lidarhd',
    neuschwanstein: 'de-by',
    zermatt: 'ch-swisstopo',
  };
  assert.ok(areas.length >= 20);
  for (const area of areas) {
    const source = sources.get(where[area.name] ?? 'si-lss');
    assert.ok(source, area.name);
    const [w = 0, s = 0, e = 0, n = 0] = regionOfPolygons([area.polygon], source.crs).bounds;
    const [west, south, east, north] = source.extent_m;
    assert.ok(w > west && s > south && e < east && n < north, area.name);
    const { width_m, height_m } = measureExtent(area);
    for (const side_m of [width_m, height_m]) {
      assert.ok(side_m > 1000 && side_m < 10_000, `${area.name}: ${side_m}`);
    }
  }
});

test('the places of the paper are on their squares', async (t) => {
  const cases: Record<string, string[]> = {
    bled: ['430_136', '431_136'],
    ljubljana: ['462_101', '461_100'],
    piran: ['388_43'],
    triglav: ['410_137'],
  };
  for (const [area, squares] of Object.entries(cases)) {
    const all = await names(t, { source: 'si-lss', area });
    for (const square of squares) {
      assert.ok(all.includes(square), `${area}: ${square} of ${all.join()}`);
    }
    assert.ok(all.length <= 64, `${area}: ${all.length} squares`);
  }
});

test('an area is found by its name however it is spelled', async () => {
  const areas = await loadAreas(kAreas, kNever);
  for (const name of ['bled', 'Bled', ' BLED ']) assert.equal(findArea(name, areas).name, 'bled');
  for (const name of ['Škofja Loka', 'skofja loka', 'SKOFJA-LOKA', 's\u030ckofjaloka']) {
    assert.equal(findArea(name, areas).name, 'skofja-loka');
  }
  for (const name of ['Köln', 'Koln', 'cologne', 'koeln']) {
    assert.equal(findArea(name, areas).name, 'koeln');
  }
  assert.throws(() => findArea('Ljubjana', areas), {
    code: 'USAGE',
    message: /area: "Ljubjana"; allowed: did you mean ljubljana\?/,
  });
  assert.throws(() => findArea('Atlantis', areas), {
    code: 'USAGE',
    message: /allowed: \d+ areas that "areas" lists$/,
  });
  assert.equal(folded('Logarska dolina (Đ, ß, Łódź)'), 'logarskadolinadsslodz');
  assert.deepEqual([editDistance('', 'bled'), editDistance('kitten', 'sitting')], [4, 3]);
});

test('a bad area file is refused', async (t) => {
  const folder = await temporaryFolder(t);
  const box = 'bbox = [14, 46, 15, 47]';
  const cases: [toml: string, message: RegExp][] = [
    ['circle = { lon = 14, lat = 46, radius_m = 5 }', /field circle\.radius_m is 5; allowed/],
    ['bbox = [15, 46, 14, 47]', /field bbox is .*west < east/],
    ['polygon = [[14, 46], [15, 46]]', /field polygon is .*at least three/],
    ['', /not exactly one of circle, polygon and bbox/],
    [`${box}\npolygon = [[14, 46], [15, 46], [15, 47]]`, /not exactly one of/],
  ];
  for (const [toml, message] of cases) {
    await writeFile(join(folder, 'x.toml'), `id = "x"\ntitle = "X"\n${toml}\n`);
    await assert.rejects(loadAreas(folder, kNever), { code: 'CONFIG', message }, toml);
  }
});

// By sampling with PROJ.
const kPiran =
  '386_43 386_44 387_42 387_43 387_44 387_45 388_42 388_43 388_44 388_45 389_43 389_44';

test('ground is chosen in any of seven ways', async (t) => {
  const range = '462_101 463_101 462_102 463_102';
  const cases: [name: string, options: SelectionOptions, squares: string][] = [
    ['names', { squares: ['462_101', '400_100'] }, '400_100 462_101'],
    ['a range', { squares: ['462_101:463_102'] }, range],
    ['a box', { bbox: [462_500, 101_500, 463_000, 102_000] }, '462_101'],
    ['degrees', { bboxDeg: [14.505, 46.045, 14.515, 46.049] }, '461_100 462_100 461_101 462_101'],
    ['a circle', { circle: [462_500, 101_500, 501] }, '462_100 461_101 462_101 463_101 462_102'],
    ['a circle in degrees', { circleDeg: [14.5154, 46.0523, 200] }, '462_101'],
    ['an area', { area: 'Piran' }, kPiran],
  ];
  for (const [name, options, squares] of cases) {
    const chosen = await names(t, { source: 'si-lss', ...options });
    assert.deepEqual(chosen.sort(), squares.split(' ').sort(), name);
  }
});

test('a choice that cannot be meant is a usage error', async (t) => {
  const bavaria = { source: 'de-by', squares: ['690_5336'] };
  const noCrs = { urlTemplate: 'http://h/{E}_{N}', area: 'bled' };
  const cases: [options: SelectionOptions, message: RegExp][] = [
    [{ source: 'de-by', area: 'bled', bbox: [0, 0, 1, 1] }, /--bbox and --area; allowed: one of/],
    [{ source: 'de-by' }, /choose squares: none given; allowed: one of --squares, --bbox/],
    [{ source: 'de-by', area: 'bled' }, /--area lies outside the source, at [\d,]+; allowed: 490/],
    [
      { ...bavaria, squares: ['690_5336:689_5337'] },
      /from its south-west square to its north-east/,
    ],
    [{ ...bavaria, squares: ['690_5336:691_5337:692_5338'] }, /E_N or a range/],
    [{ source: 'si-lss', squares: ['400_50:600_180'] }, /more than 20000 squares/],
    [{ ...bavaria, squares: ['690'] }, /"690"; allowed: E_N/],
    [{ ...bavaria, source: 'xx' }, /"xx"; allowed: ch-swisstopo, de-by/],
    [{ squares: ['1_1'] }, /--source ID, --url-template URL or --from FOLDER/],
    [{ ...bavaria, licence: 'x' }, /--licence with --source de-by/],
    [{ ...bavaria, as: 'x' }, /--as with --source de-by/],
    [{ ...bavaria, block: 'b_35' }, /has no \{block\}/],
    [noCrs, /--area without a CRS/],
    [{ urlTemplate: 'http://h/a.laz', squares: ['1_1'] }, /differs by square/],
    [{ from: kAreas, bbox: [0, 0, 1, 1] }, /without a grid/],
  ];
  for (const [options, message] of cases) {
    await assert.rejects(chosen(t, options), { code: 'USAGE', message }, String(message));
  }
});

test('a selection holds what to record and which hosts to contact', async (t) => {
  const { source, grid, gridCrs, terms, profile } = await chosen(t, {
    source: 'nl-ahn',
    squares: ['85_446'],
  });
  assert.deepEqual(
    { source, grid, gridCrs },
    { source: 'nl-ahn', grid: 'nl-ahn', gridCrs: 'EPSG:28992' },
  );
  assert.equal(terms.classTable, 'nl-ahn');
  assert.deepEqual(profile, {
    max_concurrent: 4,
    max_per_s: null,
    missing_status: [403, 404],
    hosts: ['fsn1.your-objectstorage.com'],
    privateOrigins: [],
    secretHeaders: {},
    secretOrigins: ['https://fsn1.your-objectstorage.com'],
    square_m: 1000,
  });
  const usa = await chosen(t, { source: 'us-3dep', area: 'autzen' });
  assert.deepEqual([usa.terms.crs, usa.gridCrs, usa.profile.square_m], [null, 'EPSG:3857', null]);
  assert.deepEqual(usa.profile.hosts, [
    'planetarycomputer.microsoft.com',
    'usgslidareuwest.blob.core.windows.net',
  ]);
});

test('an address that was typed needs no source, or stands in for that of one', async (t) => {
  const plain = await chosen(t, {
    urlTemplate: 'http://nas.local/{name}.laz',
    squares: ['castle'],
    as: 'mine',
    licence: 'CC0',
  });
  assert.equal(plain.source, 'mine');
  assert.deepEqual(plain.profile.hosts, ['nas.local']);
  assert.deepEqual(plain.profile.privateOrigins, []);
  assert.deepEqual(
    (await found(plain.catalogue, plain.region)).map(({ urls, bounds }) => [urls, bounds]),
    [[['http://nas.local/castle.laz'], null]],
  );
  const grid = await chosen(t, {
    urlTemplate: 'http://h/{zone}/{x:06}_{y}.laz',
    set: { zone: '32' },
    circleDeg: [14.5154, 46.0523, 200],
    crs: 'EPSG:3794',
  });
  const [square] = await found(grid.catalogue, grid.region);
  assert.deepEqual([square?.name, square?.urls], ['462_101', ['http://h/32/462000_101000.laz']]);
  const instead = await chosen(t, {
    source: 'si-lss',
    urlTemplate: 'http://h/{block}/{E}_{N}.laz',
    squares: ['462_101'],
    block: 'b_35',
  });
  assert.equal(
    (await found(instead.catalogue, instead.region))[0]?.urls[0],
    'http://h/b_35/462_101.laz',
  );
  assert.equal(instead.terms.classTable, 'si-lss');
  const own = await chosen(t, { source: 'si-lss', squares: ['462_101'] });
  assert.ok(
    !instead.profile.secretOrigins.includes('http://h'),
    "a source's secrets are not for an address that was typed",
  );
  assert.deepEqual(instead.profile.secretOrigins, own.profile.secretOrigins);
});

test('a folder is a catalogue of file addresses, and what it lacks is a hole', async (t) => {
  const folder = await temporaryFolder(t);
  await mkdir(join(folder, 'b_35'));
  for (const name of [
    'b_35/TM_462_101.laz',
    'b_35/TM_462_101.zlas',
    'TM_463_101.las',
    'notes.laz',
    '.TM_464_101.laz',
    'TM_464_102.txt',
  ]) {
    await writeFile(join(folder, name), 'x');
  }
  const url = (name: string): string => pathToFileURL(join(folder, name)).href;
  const shown = async (options: SelectionOptions): Promise<[string, readonly string[]][]> => {
    const { catalogue, region } = await chosen(t, { from: folder, ...options });
    return (await found(catalogue, region)).map((one) => [one.name, one.urls]);
  };
  assert.deepEqual(await shown({ source: 'si-lss' }), [
    ['462_101', [url('b_35/TM_462_101.laz')]],
    ['463_101', [url('TM_463_101.las')]],
  ]);
  assert.deepEqual(await shown({ source: 'si-lss', bbox: [462_000, 101_000, 463_000, 103_000] }), [
    ['462_101', [url('b_35/TM_462_101.laz')]],
    ['462_102', []],
  ]);
  assert.deepEqual(
    (await shown({})).map(([name]) => name),
    ['TM_462_101', 'TM_463_101', 'notes'],
  );
  assert.deepEqual(await shown({ squares: ['notes', 'nothing'] }), [
    ['notes', [url('notes.laz')]],
    ['nothing', []],
  ]);
  const { ignored } = await chosen(t, { from: folder, source: 'si-lss' });
  assert.deepEqual(ignored, [join(folder, 'notes.laz')]);

  await mkdir(join(folder, 'copy'));
  await writeFile(join(folder, 'copy', 'notes.laz'), 'y');
  await assert.rejects(shown({}), {
    code: 'AMBIGUOUS_FILE',
    message: /both claim it; allowed: one file/,
  });
  for (const [from, message] of [
    [join(folder, 'nowhere'), /read folder .*nowhere/],
    [await temporaryFolder(t), /holds no files of squares/],
  ] as const) {
    await assert.rejects(chosen(t, { from }), { code: 'USAGE', message });
  }
  const named = await shown({ source: 'si-lss', squares: ['463_101', '464_101'] });
  assert.deepEqual(named, [
    ['463_101', [url('TM_463_101.las')]],
    ['464_101', []],
  ]);
});

// By sampling with PROJ.
const kTriangleSquares =
  '461_100 461_101 461_102 462_100 462_101 462_102 462_103 463_100 463_101 463_102'.split(' ');
const kTriangle = {
  type: 'Polygon',
  coordinates: [
    [
      [14.5, 46.045],
      [14.53, 46.045],
      [14.515, 46.07],
      [14.5, 46.045],
    ],
  ],
};

async function polygonFile(
  t: TestContext,
  geometry: unknown,
  driver?: string,
  extension = 'geojson',
): Promise<string> {
  const folder = await temporaryFolder(t);
  const geojson = join(folder, 'in.geojson');
  await writeFile(
    geojson,
    JSON.stringify({
      type: 'FeatureCollection',
      features: [{ type: 'Feature', properties: {}, geometry }],
    }),
  );
  if (driver === undefined) return geojson;
  const file = join(folder, `out.${extension}`);
  // In metres, so that the file's own CRS matters; KML has degrees only.
  const crs = driver === 'KML' ? [] : ['-t_srs', 'EPSG:3794'];
  execFileSync('ogr2ogr', ['-f', driver, ...crs, file, geojson], { stdio: 'ignore' });
  return file;
}

/** GDAL would read this as VRT, whatever its name. */
async function leading(t: TestContext): Promise<string> {
  const target = await polygonFile(t, kTriangle);
  const file = join(await temporaryFolder(t), 'leading.kml');
  await writeFile(
    file,
    '<OGRVRTDataSource><OGRVRTLayer ' +
      `name="in"><SrcDataSource>${target}</SrcDataSource></OGRVRTLayer></OGRVRTDataSource>`,
  );
  execFileSync('ogrinfo', ['-ro', '-so', file, 'in'], { stdio: 'ignore' });
  return file;
}

test('polygons come from every supported format', async (t) => {
  const expected = await names(t, { source: 'si-lss', polygon: await polygonFile(t, kTriangle) });
  assert.deepEqual(expected.sort(), kTriangleSquares);
  const formats = [
    ['ESRI Shapefile', 'shp'],
    ['GPKG', 'gpkg'],
    ['FlatGeobuf', 'fgb'],
    ['KML', 'kml'],
  ] as const;
  for (const [driver, extension] of formats) {
    await t.test(driver, async (t) => {
      const file = await polygonFile(t, kTriangle, driver, extension);
      assert.deepEqual((await names(t, { source: 'si-lss', polygon: file })).sort(), expected);
    });
  }
});

test('an outline too long to follow is refused before it fills memory', () => {
  const zigzag = Array.from({ length: 20_001 }, (_unused, index): [number, number] => [
    13 + index * 1e-6,
    index % 2 === 0 ? 45 : 46,
  ]);
  assert.throws(() => regionOfPolygons([[zigzag]], 'EPSG:3794'), {
    code: 'USAGE',
    message: /outline of 4020000 pieces of 500 m or less; allowed: at most 2000000/,
  });
});

test('a polygon file that cannot be used is an error with the reason', async (t) => {
  const folder = await temporaryFolder(t);
  const bad = join(folder, 'bad.geojson');
  await writeFile(bad, 'no geojson');
  const point = await polygonFile(t, { type: 'Point', coordinates: [14.5, 46] });
  const cases: [name: string, file: string, message: RegExp][] = [
    ['nothing there', join(folder, 'nowhere.shp'), /no such file/],
    ['a folder', folder, /not a file/],
    ['no format', bad, /bad\.geojson: .*allowed: ESRI Shapefile/],
    ['leads to another', await leading(t), /leading\.kml: .*allowed: ESRI Shapefile/],
    ['a virtual file', '/vsicurl/http://127.0.0.1/a.geojson', /virtual file/],
    ['a connection', 'PG:dbname=x', /no such file/],
    ['a point', point, /feature 1 is Point; allowed: Polygon/],
    ['nowhere', await polygonFile(t, null), /without a geometry/],
  ];
  for (const [name, file, message] of cases) {
    await t.test(name, async (t) =>
      assert.rejects(chosen(t, { source: 'si-lss', polygon: file }), {
        code: 'POLYGON_FILE',
        message,
      }),
    );
  }
});

test('the program that reads polygons gets no secrets', async (t) => {
  const folder = await temporaryFolder(t);
  const seen = join(folder, 'environment');
  await writeFile(
    join(folder, 'ogr2ogr'),
    `#!/bin/sh\nenv > ${seen}\nexec /usr/bin/ogr2ogr "$@"\n`,
    { mode: 0o755 },
  );
  const polygon = await polygonFile(t, kTriangle);
  const before = process.env;
  t.after(() => {
    process.env = before;
  });
  process.env = {
    ...before,
    PATH: `${folder}:${before['PATH']}`,
    PORTAL_TOKEN: 'hush',
    LD_PRELOAD_NOT: 'x',
    GDAL_DATA: before['GDAL_DATA'] ?? '/usr/share/gdal',
  };
  assert.deepEqual((await names(t, { source: 'si-lss', polygon })).sort(), kTriangleSquares);
  const passed = (await readFile(seen, 'utf8'))
    .split('\n')
    .flatMap((line) => /^\w+(?==)/.exec(line) ?? []);
  const shell = ['PWD', 'OLDPWD', 'SHLVL', '_'];
  assert.deepEqual(passed.filter((name) => !shell.includes(name)).sort(), [
    'GDAL_DATA',
    'HOME',
    'LANG',
    'LC_ALL',
    'OGR_SKIP',
    'PATH',
    'TMPDIR',
  ]);
});
