import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { test, type TestContext } from 'node:test';
import {
  editDistance,
  extentOf,
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
import { openCatalogue } from '../../../grabber/src/sources/catalogue/open-catalogue.js';
import { loadSources } from '../../../grabber/src/sources/load-sources.js';
import type { Source } from '../../../grabber/src/sources/source.js';
import { readPackageInfo } from '../../../grabber/src/util/package-info.js';
import { clientFor, found } from '../support/catalogue-fixture.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';

const kConfig = join(readPackageInfo().root, '..', 'config');
const kAreas = join(kConfig, 'areas');
const shipped = (): Promise<ReadonlyMap<string, Source>> =>
  loadSources(join(kConfig, 'sources'), kNever);

async function chosen(t: TestContext, options: SelectionOptions): Promise<Selection> {
  return select({ areasFolder: kAreas, ...options }, await shipped(), clientFor(t), kNever);
}

async function names(t: TestContext, options: SelectionOptions): Promise<string[]> {
  const { catalogue, region } = await chosen(t, options);
  return (await found(catalogue, region)).map(({ name }) => name);
}

test('every shipped area lies in a source, and is of a size to fetch', async (t) => {
  const areas = await loadAreas(kAreas, kNever);
  const sources = await shipped();
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
    await t.test(area.name, () => {
      const source = sources.get(where[area.name] ?? 'si-lss');
      assert.ok(source);
      const region = regionOfPolygons([area.polygon], source.crs);
      const [west, south, east, north] = source.extent_m;
      assert.ok(
        region.bounds[0] > west &&
          region.bounds[1] > south &&
          region.bounds[2] < east &&
          region.bounds[3] < north,
      );
      const { width_m, height_m } = extentOf(area);
      assert.ok(
        width_m > 1000 && width_m < 10_000 && height_m > 1000 && height_m < 10_000,
        `${width_m} x ${height_m}`,
      );
    });
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

test('an area is found by its name however it is spelled', async (t) => {
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
  await t.test('folding and distance', () => {
    assert.equal(folded('Logarska dolina (Đ, ß, Łódź)'), 'logarskadolinadsslodz');
    assert.equal(editDistance('bled', 'bled'), 0);
    assert.equal(editDistance('', 'bled'), 4);
    assert.equal(editDistance('kitten', 'sitting'), 3);
  });
});

test('a bad area file is refused', async (t) => {
  const folder = await temporaryFolder(t);
  const cases: { toml: string; message: RegExp }[] = [
    {
      toml: 'circle = { lon = 14, lat = 46, radius_m = 5 }',
      message: /field circle\.radius_m is 5; allowed: a table/,
    },
    { toml: 'bbox = [15, 46, 14, 47]', message: /field bbox is .*west < east/ },
    { toml: 'polygon = [[14, 46], [15, 46]]', message: /field polygon is .*at least three/ },
    { toml: '', message: /not exactly one of circle, polygon and bbox/ },
    {
      toml: 'bbox = [14, 46, 15, 47]\npolygon = [[14, 46], [15, 46], [15, 47]]',
      message: /not exactly one of/,
    },
  ];
  for (const { toml, message } of cases) {
    await writeFile(join(folder, 'x.toml'), `id = "x"\ntitle = "X"\n${toml}\n`);
    await assert.rejects(loadAreas(folder, kNever), { code: 'CONFIG', message }, toml);
  }
});

// By sampling with PROJ.
const kPiran =
  '386_43 386_44 387_42 387_43 387_44 387_45 388_42 388_43 388_44 388_45 389_43 389_44'.split(' ');

test('ground is chosen in any of seven ways', async (t) => {
  const cases: { name: string; options: SelectionOptions; squares: string[] }[] = [
    {
      name: 'names',
      options: { squares: ['462_101', '400_100'] },
      squares: ['400_100', '462_101'],
    },
    {
      name: 'a range',
      options: { squares: ['462_101:463_102'] },
      squares: ['462_101', '463_101', '462_102', '463_102'],
    },
    {
      name: 'a box',
      options: { bbox: [462_500, 101_500, 463_000, 102_000] },
      squares: ['462_101'],
    },
    {
      name: 'a box in degrees',
      options: { bboxDeg: [14.505, 46.045, 14.515, 46.049] },
      squares: ['461_100', '462_100', '461_101', '462_101'],
    },
    {
      name: 'a circle',
      options: { circle: [462_500, 101_500, 501] },
      squares: ['462_100', '461_101', '462_101', '463_101', '462_102'],
    },
    {
      name: 'a circle in degrees',
      options: { circleDeg: [14.5154, 46.0523, 200] },
      squares: ['462_101'],
    },
    { name: 'an area', options: { area: 'Piran' }, squares: kPiran },
  ];
  for (const { name, options, squares } of cases) {
    await t.test(name, async (t) =>
      assert.deepEqual(
        (await names(t, { source: 'si-lss', ...options })).sort(),
        [...squares].sort(),
      ),
    );
  }
});

test('a choice that cannot be meant is a usage error', async (t) => {
  const cases: { name: string; options: SelectionOptions; message: RegExp }[] = [
    {
      name: 'two ways',
      options: { source: 'de-by', area: 'bled', bbox: [0, 0, 1, 1] },
      message: /choose squares: --bbox and --area; allowed: one of them/,
    },
    {
      name: 'none',
      options: { source: 'de-by' },
      message: /choose squares: none given; allowed: one of --squares, --bbox/,
    },
    {
      name: 'another country',
      options: { source: 'de-by', area: 'bled' },
      message: /--area lies outside the source, at [\d,]+; allowed: 490000/,
    },
    {
      name: 'degrees for metres',
      options: { source: 'de-by', bbox: [11, 48, 12, 49] },
      message: /lies outside the source/,
    },
    {
      name: 'a range backwards',
      options: { source: 'de-by', squares: ['690_5336:689_5337'] },
      message: /from its south-west square to its north-east/,
    },
    {
      name: 'a range of three',
      options: { source: 'de-by', squares: ['690_5336:691_5337:692_5338'] },
      message: /E_N or a range/,
    },
    {
      name: 'a whole country',
      options: { source: 'si-lss', squares: ['400_50:600_180'] },
      message: /more than 20000 squares/,
    },
    {
      name: 'a name of another form',
      options: { source: 'de-by', squares: ['690'] },
      message: /"690"; allowed: E_N/,
    },
    {
      name: 'an unknown source',
      options: { source: 'xx', squares: ['1_1'] },
      message: /"xx"; allowed: ch-swisstopo, de-by/,
    },
    {
      name: 'no source',
      options: { squares: ['1_1'] },
      message: /--source ID, --url-template URL or --from FOLDER/,
    },
    {
      name: 'words of an own source',
      options: { source: 'de-by', squares: ['690_5336'], licence: 'x' },
      message: /--licence with --source de-by/,
    },
    {
      name: 'a block where there is none',
      options: { source: 'de-by', squares: ['690_5336'], block: 'b_35' },
      message: /has no \{block\}/,
    },
    {
      name: 'degrees without a CRS',
      options: { urlTemplate: 'http://h/{E}_{N}', area: 'bled' },
      message: /--area without a CRS/,
    },
    {
      name: 'a template that names nothing',
      options: { urlTemplate: 'http://h/a.laz', squares: ['1_1'] },
      message: /differs by square/,
    },
    {
      name: 'a folder by place',
      options: { from: kAreas, bbox: [0, 0, 1, 1] },
      message: /without a grid/,
    },
  ];
  for (const { name, options, message } of cases) {
    await t.test(name, async (t) => {
      await assert.rejects(chosen(t, options), (error: Error & { code?: string }) => {
        assert.equal(error.code, 'USAGE');
        assert.match(error.message, message);
        return true;
      });
    });
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
  await assert.rejects(chosen(t, { from: join(folder, 'nowhere') }), {
    code: 'USAGE',
    message: /read folder .*nowhere/,
  });
  await assert.rejects(chosen(t, { from: await temporaryFolder(t) }), {
    code: 'USAGE',
    message: /holds no files of squares/,
  });
});

test('a square requested by name is never dropped, even if no catalogue lists it', async (t) => {
  const folder = await temporaryFolder(t);
  await writeFile(join(folder, 'TM_462_101.laz'), 'x');
  const { catalogue, region } = await chosen(t, {
    from: folder,
    source: 'si-lss',
    squares: ['462_101', '463_101'],
  });
  const squares = await found(catalogue, region);
  assert.deepEqual(
    squares.map(({ name, urls }) => [name, urls.length]),
    [
      ['462_101', 1],
      ['463_101', 0],
    ],
  );
  const [, hole] = squares;
  assert.ok(hole);
  assert.equal(await catalogue.locate?.(hole, [], () => Promise.resolve(true), kNever), undefined);
});

// By sampling with PROJ.
const kTriangleSquares = [
  '461_100',
  '461_101',
  '461_102',
  '462_100',
  '462_101',
  '462_102',
  '462_103',
  '463_100',
  '463_101',
  '463_102',
];
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
  const cases: { name: string; file: string; message: RegExp }[] = [
    { name: 'nothing there', file: join(folder, 'nowhere.shp'), message: /no such file/ },
    { name: 'a folder', file: folder, message: /not a file/ },
    { name: 'no format', file: bad, message: /bad\.geojson: .*allowed: ESRI Shapefile/ },
    {
      name: 'a file that leads to another',
      file: await leading(t),
      message: /leading\.kml: .*allowed: ESRI Shapefile/,
    },
    {
      name: 'a virtual file',
      file: '/vsicurl/http://127.0.0.1/a.geojson',
      message: /virtual file/,
    },
    { name: 'a connection', file: 'PG:dbname=x', message: /no such file/ },
    {
      name: 'a point',
      file: await polygonFile(t, { type: 'Point', coordinates: [14.5, 46] }),
      message: /feature 1 is Point; allowed: Polygon/,
    },
    { name: 'nowhere', file: await polygonFile(t, null), message: /without a geometry/ },
  ];
  for (const { name, file, message } of cases) {
    await t.test(name, async (t) =>
      assert.rejects(chosen(t, { source: 'si-lss', polygon: file }), {
        code: 'POLYGON_FILE',
        message,
      }),
    );
  }
});

test('the catalogue of a probed source can still find a block', async (t) => {
  const sources = await shipped();
  const source = sources.get('nl-ahn6');
  assert.ok(source);
  assert.ok(openCatalogue(source, clientFor(t)).locate);
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
  const before = { ...process.env };
  t.after(() => {
    process.env = before;
  });
  Object.assign(process.env, {
    PATH: `${folder}:${before['PATH']}`,
    PORTAL_TOKEN: 'hush',
    LD_PRELOAD_NOT: 'x',
    GDAL_DATA: before['GDAL_DATA'] ?? '/usr/share/gdal',
  });
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
