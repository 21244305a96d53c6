import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, join } from 'node:path';
import { deflateSync, gzipSync } from 'node:zlib';
import * as fc from 'fast-check';
import { parseConfig } from '../../../grabber/src/config/toml-file.js';
import { parseConverters } from '../../../grabber/src/convert/converters.js';
import { pointCountOf } from '../../../grabber/src/convert/zlas-header.js';
import { decoded } from '../../../grabber/src/fetch/content-coding.js';
import { DiskSpace } from '../../../grabber/src/fetch/disk-space.js';
import { addressAllowed, checkUrl } from '../../../grabber/src/fetch/host-policy.js';
import type { HttpClient, HttpResponse } from '../../../grabber/src/fetch/http-client.js';
import type { Resumable } from '../../../grabber/src/fetch/partial.js';
import { bodyPlan, isWhole } from '../../../grabber/src/fetch/response-check.js';
import { htmlError, statusError } from '../../../grabber/src/fetch/response-error.js';
import { parseRetryAfter } from '../../../grabber/src/fetch/retry.js';
import { unzipMember } from '../../../grabber/src/fetch/zip-member.js';
import { kHeaderReadBytes, readLasHeader } from '../../../grabber/src/las/header.js';
import { verifyLasFile } from '../../../grabber/src/las/verify.js';
import { kOrthoKind } from '../../../grabber/src/ortho/schema.js';
import { parseCapabilities } from '../../../grabber/src/ortho/wmts-capabilities.js';
import { readFishnet } from '../../../grabber/src/select/fishnet-file.js';
import { readPolygonFile } from '../../../grabber/src/select/polygon-file.js';
import { regionOfBox } from '../../../grabber/src/select/region.js';
import { openCatalogue } from '../../../grabber/src/sources/catalogue/open-catalogue.js';
import { parseSource } from '../../../grabber/src/sources/load-sources.js';
import {
  decodePolygon,
  encodePolygon,
  envelopeOfBlob,
} from '../../../grabber/src/store/geopackage-geometry.js';
import { storeLayout } from '../../../grabber/src/store/layout.js';
import { openStore } from '../../../grabber/src/store/open-store.js';
import { readPackageInfo } from '../../../grabber/src/util/package-info.js';
import { sourceWith } from '../support/catalogue-fixture.js';
import { fakeClock } from '../support/fake-clock.js';
import { makeLas, makeLaz } from '../support/las-fixture.js';
import { kNever, squareOf } from '../support/store-fixture.js';
import { makeZip } from '../support/zip-fixture.js';
import { arrived, damagedOneOf } from './damage.js';
import { acceptedOrRefused } from './refusal.js';

/** A reader of untrusted input, with the properties that must hold for every input. */
export type Target = {
  readonly name: string;
  /** In `npm test`, which takes a few seconds for all targets together. */
  readonly runs: number;
  readonly property: fc.IRawProperty<unknown>;
};

const kConfig = join(readPackageInfo().root, '..', 'config');
const kDisk = {
  disk: new DiskSpace(tmpdir(), () => 2 ** 40),
  clock: fakeClock(),
  max_bytes: 64 * 1024 * 1024,
};

/** A folder for the files of this process, removed at its end. */
const kFolder = mkdtempSync(join(tmpdir(), 'terravox-fuzz-'));
process.on('exit', () => rmSync(kFolder, { recursive: true, force: true }));

function target<T>(
  name: string,
  runs: number,
  input: fc.Arbitrary<T>,
  check: (input: T) => unknown,
): Target {
  const property = fc.asyncProperty(input, async (value) => void (await check(value)));
  return { name, runs, property: property as fc.IRawProperty<unknown> };
}

/** Good files and their damaged copies, written to a file of that name. */
function files(
  name: string,
  runs: number,
  good: readonly Buffer[],
  file: string,
  check: (path: string, bytes: Buffer) => unknown,
): Target {
  return target(name, runs, damagedOneOf(good.length), (input) => {
    const path = join(kFolder, file);
    const bytes = arrived(good, input);
    writeFileSync(path, bytes);
    return check(path, bytes);
  });
}

function lasTargets(): Target[] {
  const good = [
    makeLas(),
    makeLas({ minor: 4, format: 6 }),
    makeLas({ minor: 0, format: 0, points: 3 }),
    makeLaz(),
    makeLaz({ minor: 4, format: 7, streamed: true }),
  ];
  const codes = ['NOT_LAS', 'LAS_HEADER', 'LAS_TRUNCATED'] as const;
  const header = target(
    'las-header',
    2000,
    fc.tuple(damagedOneOf(good.length), fc.maxSafeNat()),
    async ([input, size]) => {
      const start = arrived(good, input).subarray(0, kHeaderReadBytes);
      pointCountOf(start);
      const read = await acceptedOrRefused(codes, () => readLasHeader(start, size, 'a file'));
      if (read === undefined) return;
      assert.ok(Number.isSafeInteger(read.pointCount) && read.pointCount >= 1);
      assert.ok(
        read.compressed ||
          read.pointOffset_bytes + read.pointCount * read.recordLength_bytes <= size,
      );
      for (const axis of [0, 1, 2] as const) assert.ok(read.min[axis] <= read.max[axis]);
    },
  );
  const whole = files('las-file', 400, good, 'points.laz', (path) =>
    acceptedOrRefused(codes, () => verifyLasFile(path, 'a file', kNever)),
  );
  return [header, whole];
}

function zipTarget(): Target {
  const laz = makeLaz({ dataBytes: 3000 });
  const good = [
    makeZip([
      { name: 'readme.txt', data: Buffer.from('hello') },
      { name: 'a/x.laz', data: laz },
    ]),
    makeZip([{ name: 'x.laz', data: laz, stored: true }]),
  ];
  return files('zip-member', 200, good, 'archive.zip', async (path) => {
    const taken = await acceptedOrRefused(['ARCHIVE', 'TOO_LARGE'], () =>
      unzipMember(path, '*', join(kFolder, 'member'), 'an archive', kDisk, kNever),
    );
    if (taken !== undefined) assert.ok(taken.bytes <= kDisk.max_bytes);
  });
}

function geometryTargets(): Target[] {
  const good = [
    encodePolygon([
      [
        [14, 46],
        [15, 46],
        [15, 47],
        [14, 46],
      ],
    ]),
    encodePolygon([
      [
        [14, 46],
        [15, 46],
        [15, 47],
        [14, 46],
      ],
      [
        [14.1, 46.1],
        [14.2, 46.1],
        [14.2, 46.2],
        [14.1, 46.1],
      ],
    ]),
  ];
  const damaged = target('gpkg-geometry', 2000, damagedOneOf(good.length), async (input) => {
    const blob = arrived(good, input);
    envelopeOfBlob(blob);
    const rings = await acceptedOrRefused(['STORE_DAMAGED'], () => decodePolygon(blob, 'a row'));
    for (const position of rings?.flat() ?? []) assert.ok(position.every(Number.isFinite));
  });
  const number = fc.double({ noNaN: true, noDefaultInfinity: true });
  const ring = fc.array(fc.tuple(number, number), { minLength: 1, maxLength: 20 });
  const same = target(
    'gpkg-geometry-roundtrip',
    300,
    fc.array(ring, { minLength: 1, maxLength: 5 }),
    (rings) => assert.deepEqual(decodePolygon(encodePolygon(rings), 'a row'), rings),
  );
  return [damaged, same];
}

function storeTarget(): Target {
  const root = join(kFolder, 'store');
  const path = storeLayout(root).database;
  const store = openStore(root, {}, kNever);
  const terms = { crs: 'EPSG:3794', classTable: 'asprs', licence: 'CC0', attribution: 'Us' };
  const names = Array.from({ length: 40 }, (_unused, index) => `${462 + index}_101`);
  store.squares.learn(
    'here',
    'here',
    'EPSG:3794',
    terms,
    names.map((name) => squareOf(name, [`https://h.example/${name}`])),
  );
  store.close();
  const good = readFileSync(path);
  return target('gpkg-store', 60, damagedOneOf(1), (input) => {
    writeFileSync(path, arrived([good], input));
    return acceptedOrRefused(['STORE_FORMAT', 'STORE_DAMAGED', 'STORE_IO'], () => {
      const opened = openStore(root, { readOnly: true }, kNever);
      try {
        opened.squares.tally();
        return opened.squares.list({}).length + opened.orthophotos.list({}).length;
      } finally {
        opened.close();
      }
    });
  });
}

/**
 * Squares of the fishnet of a survey, as GDAL writes them in each format. Each run starts programs,
 * hence few runs.
 */
function vectorTargets(): Target[] {
  const kinds = [
    { driver: 'GeoJSON', name: 'net.geojson' },
    { driver: 'ESRI Shapefile', name: 'net.shp' },
    { driver: 'ESRI Shapefile', name: 'net.dbf' },
    { driver: 'GPKG', name: 'net.gpkg' },
    { driver: 'KML', name: 'net.kml' },
    { driver: 'FlatGeobuf', name: 'net.fgb' },
  ];
  const source = sourceWith(
    '[access]\nkind = "template"\nurls = ["https://h.example/{E}_{N}.laz"]',
  );
  const square = [
    [14.4, 46],
    [14.5, 46],
    [14.5, 46.1],
    [14.4, 46],
  ];
  const features = ['462_101', '463_101'].map((NAME) => ({
    type: 'Feature',
    properties: { NAME, BLOK: 'b_35' },
    geometry: { type: 'Polygon', coordinates: [square] },
  }));
  const plain = join(kFolder, 'in.geojson');
  return kinds.map(({ driver, name }) => {
    // Made on first use: a run of another target needs no GDAL.
    let good: Buffer | undefined;
    const folder = join(kFolder, `vector-${driver.replaceAll(' ', '-')}-${name}`);
    const path = join(folder, name);
    const make = (): Buffer => {
      writeFileSync(plain, JSON.stringify({ type: 'FeatureCollection', features }));
      mkdirSync(folder);
      execFileSync('ogr2ogr', ['-f', driver, join(folder, name.replace('.dbf', '.shp')), plain], {
        stdio: 'ignore',
      });
      return readFileSync(path);
    };
    return target(
      `import-${name.slice(name.indexOf('.') + 1)}`,
      2,
      damagedOneOf(1),
      async (input) => {
        good ??= make();
        writeFileSync(path, arrived([good], input));
        await acceptedOrRefused(['FISHNET'], () => readFishnet(path, source, {}, {}, kNever));
        await acceptedOrRefused(['POLYGON_FILE'], () => readPolygonFile(path, kNever));
      },
    );
  });
}

/** Values of headers as servers send them, nearly as they send them, and anything else. */
const headerValue = fc.oneof(
  fc.string({ maxLength: 60 }),
  fc.string({ unit: 'binary', maxLength: 60 }),
  fc.integer().map(String),
  fc.double().map(String),
  fc.date({ noInvalidDate: false }).map(String),
  fc.date().map((date) => date.toUTCString()),
  fc
    .tuple(fc.nat(), fc.nat(), fc.oneof(fc.nat().map(String), fc.constant('*')))
    .map(([a, b, c]) => `bytes ${a}-${b}/${c}`),
  fc.constantFrom(
    'gzip',
    'deflate',
    'identity',
    'br',
    '"tag"',
    'text/html',
    'bytes */5',
    'bytes 5-9/10',
  ),
);
const kHeaders = [
  'content-length',
  'content-range',
  'content-encoding',
  'content-type',
  'etag',
  'last-modified',
  'retry-after',
  'location',
] as const;
const headers = fc.dictionary(fc.constantFrom(...kHeaders), headerValue, {
  maxKeys: kHeaders.length,
});

function responseOf(
  status: number,
  values: Readonly<Record<string, string>>,
  body: Uint8Array = Buffer.alloc(0),
): HttpResponse {
  async function* once(): AsyncGenerator<Uint8Array> {
    yield await Promise.resolve(body);
  }
  return { status, header: (name) => values[name], body: once(), discard: () => Promise.resolve() };
}

function httpTargets(): Target[] {
  const now = new Date('2026-06-21T12:00:00Z');
  const url = 'https://h.example/a.laz';
  const retryAfter = target('retry-after', 2000, headerValue, (value) => {
    const wait_ms = parseRetryAfter(value, now);
    if (wait_ms !== undefined) {
      assert.ok(Number.isFinite(wait_ms) && wait_ms >= 0, `waits ${wait_ms} ms`);
    }
  });
  const status = fc.constantFrom(200, 206, 404, 416, 429, 500, 503);
  const part: Resumable = { url, offset_bytes: 5, if_range: '"tag"', total_bytes: 10 };
  const responses = target(
    'http-headers',
    2000,
    fc.tuple(status, headers, fc.boolean(), fc.uint8Array()),
    async ([code, values, resumed, start]) => {
      const response = responseOf(code, values);
      const resumable = resumed ? part : undefined;
      const plan = await acceptedOrRefused(['HTTP_PROTOCOL', 'RESUME_REFUSED'], () =>
        bodyPlan(url, response, resumable),
      );
      if (plan !== undefined) {
        assert.ok(plan.offset_bytes === 0 || plan.offset_bytes === part.offset_bytes);
        assert.ok(plan.total_bytes === undefined || Number.isSafeInteger(plan.total_bytes));
      }
      isWhole(response, part);
      const wait_ms = statusError(url, response, [404], now).retryAfterMs;
      assert.ok(wait_ms === undefined || (Number.isFinite(wait_ms) && wait_ms >= 0));
      htmlError(url, response, start, (text) => text);
    },
  );
  const text = Buffer.from('points '.repeat(500));
  const packed = [gzipSync(text), deflateSync(text)];
  const codings = target('content-coding', 200, damagedOneOf(packed.length), (input) =>
    acceptedOrRefused(['HTTP_PROTOCOL', 'TOO_LARGE'], async () => {
      const body = responseOf(200, {}, arrived(packed, input)).body;
      let bytes = 0;
      for await (const piece of decoded(body, input.base === 0 ? 'gzip' : 'deflate', url)) {
        bytes += piece.length;
      }
      return bytes;
    }),
  );
  return [retryAfter, responses, codings, addressTarget()];
}

function addressTarget(): Target {
  const access = {
    hosts: ['data.example', '127.0.0.1', 'files.example:8080'],
    privateOrigins: ['http://127.0.0.1:8000'],
  };
  const part = fc.constantFrom(
    ...[
      'http:',
      'https:',
      '//',
      '/',
      '\\',
      '@',
      ':',
      '8000',
      '8080',
      '127.0.0.1',
      '0x7f.1',
      '2130706433',
      '[::1]',
      '[::ffff:127.0.0.1]',
    ],
    ...[
      'data.example',
      'files.example',
      'localhost',
      '.',
      '?',
      '#',
      '%2f',
      '\t',
      '\n',
      'user',
      'file:',
      '。',
      '１',
    ],
  );
  const address = fc.oneof(
    fc.webUrl(),
    fc
      .array(fc.oneof(part, fc.string({ maxLength: 4 })), { maxLength: 8 })
      .map((parts) => parts.join('')),
  );
  return target('address', 3000, address, async (text) => {
    const url = await acceptedOrRefused(['HOST_REFUSED'], () => checkUrl(text, access));
    if (url === undefined) return;
    assert.ok(
      ['http:', 'https:'].includes(url.protocol) && url.username === '' && url.password === '',
    );
    assert.ok(access.hosts.includes(url.hostname) || access.hosts.includes(url.host), url.href);
    if (/^[\d.]+$|^\[/.test(url.hostname)) {
      assert.ok(
        access.privateOrigins.includes(url.origin) && addressAllowed(url.hostname, true),
        url.href,
      );
    }
  });
}

function tomlTargets(): Target[] {
  const good = [
    ...['si-lss', 'us-3dep', 'nl-ahn'].map((name) => join(kConfig, 'sources', `${name}.toml`)),
    join(kConfig, 'areas', 'bled.toml'),
    join(kConfig, 'converters.toml'),
  ].map((path) => ({ name: basename(path), text: readFileSync(path) }));
  const damaged = damagedOneOf(good.length).map((input) => ({ ...good[input.base], input }));
  const check = (text: string, name: string): Promise<unknown> =>
    acceptedOrRefused(['CONFIG'], () => {
      const kinds = [
        () => parseSource(text, name),
        () => parseConfig(text, name, kOrthoKind),
        () => parseConverters(text, name),
      ];
      for (const kind of kinds) kind();
    });
  const bytes = target('toml', 600, damaged, async ({ name = 'a.toml', input }) => {
    await check(
      arrived(
        good.map(({ text }) => text),
        input,
      ).toString('utf8'),
      name,
    );
  });
  const nested = target('toml-nesting', 20, fc.nat(20_000), (depth) =>
    check(`a = ${'['.repeat(depth)}`, 'a.toml'),
  );
  const values = target(
    'toml-values',
    400,
    fc.tuple(fc.nat(30), tomlValue),
    async ([line, value]) => {
      const lines = (good[0]?.text.toString('utf8') ?? '').split('\n');
      const index = line % lines.length;
      lines[index] = (lines[index] ?? '').replace(/=.*$/, `= ${value}`);
      await check(lines.join('\n'), 'si-lss.toml');
    },
  );
  return [bytes, nested, values];
}

const tomlValue = fc.oneof(
  fc.string({ maxLength: 50 }).map((text) => JSON.stringify(text)),
  fc.constantFrom(
    'nan',
    'inf',
    '-inf',
    '0',
    '-1',
    '1e400',
    '9223372036854775807',
    '0xffffffffffffffff',
    'true',
    '{}',
    '[]',
    '[[]]',
  ),
  fc.constantFrom(
    '1979-05-27T07:32:00Z',
    '0000-00-00',
    '9999-99-99',
    '07:32:00',
    '{ a = 1979-05-27 }',
    '[1979-02-30]',
    '"(((((a+)+)+)+)+)+$"',
  ),
  fc.double().map(String),
);

/**
 * Replies of catalogues: JSON of any form, and replies that have the right form with values that
 * are not.
 */
function replyTargets(): Target[] {
  const stac = sourceWith(
    '[access]\nkind = "stac"\nitems = "https://h.example/items"\nname_pattern = ' +
      "'_(?<E>\\d+)-(?<N>\\d+)'\n[[access.assets]]\nhref = 'laz$'",
  );
  const wfs = sourceWith(
    '[access]\nkind = "wfs"\nurl = "https://h.example/wfs"\ntype = "a:b"\nname_field = ' +
      '"NAME"\nurl_field = "URL"\nname_pattern = \'(?<E>\\d+)_(?<N>\\d+)\'',
  );
  const any = fc.jsonValue({ maxDepth: 4 });
  const text = fc.oneof(
    fc.constantFrom(
      'x_462-101',
      '462_101',
      'https://h.example/a.laz',
      'https://evil.example/',
      'file:///etc/passwd',
      '',
    ),
    fc.string(),
  );
  const value = fc.oneof(any, text);
  const feature = fc.record(
    {
      id: value,
      type: fc.constant('Feature'),
      bbox: fc.oneof(any, fc.array(fc.double(), { minLength: 4, maxLength: 6 })),
      geometry: value,
      properties: fc.oneof(
        any,
        fc.record({ NAME: value, URL: value, datetime: value }, { requiredKeys: [] }),
      ),
      assets: fc.oneof(
        any,
        fc.dictionary(
          fc.string({ maxLength: 4 }),
          fc.record({ href: value, type: value }, { requiredKeys: [] }),
          { maxKeys: 3 },
        ),
      ),
    },
    { requiredKeys: [] },
  );
  const links = fc.array(
    fc.record({ rel: fc.constantFrom('next', 'self'), href: value }, { requiredKeys: [] }),
    { maxLength: 2 },
  );
  const reply = fc.oneof(
    any,
    fc.record(
      { features: fc.array(feature, { maxLength: 4 }), links, numberMatched: value },
      { requiredKeys: ['features'] },
    ),
  );
  const region = regionOfBox([462_000, 101_000, 463_000, 102_000]);
  return (
    [
      ['stac', stac],
      ['wfs', wfs],
    ] as const
  ).map(([kind, source]) =>
    target(`reply-${kind}`, 400, reply, async (json) => {
      const answer = Buffer.from(JSON.stringify(json));
      const get = (): Promise<HttpResponse> => Promise.resolve(responseOf(200, {}, answer));
      const http: HttpClient = { get, redact: (words) => words, close: () => Promise.resolve() };
      const policy = { retries: 0, base_ms: 1, cap_ms: 1, max_wait_ms: 1 };
      const limits = { pages: 5 };
      await acceptedOrRefused(['CATALOGUE', 'TEMPLATE'], async () => {
        const catalogue = openCatalogue(source, http, { policy, clock: fakeClock(), limits });
        for await (const square of catalogue.find(region, kNever)) {
          for (const url of square.urls) assert.match(url, /^https?:/);
          assert.match(square.name, /^[^/\\]+$/);
          assert.ok(!square.name.includes('\0'));
        }
      });
    }),
  );
}

function capabilitiesTarget(): Target {
  const matrix = [
    '<TileMatrix><ows:Identifier>0</ows:Identifier>',
    '<ScaleDenominator>1000</ScaleDenominator><TopLeftCorner>0 100</TopLeftCorner>',
    '<TileWidth>256</TileWidth><TileHeight>256</TileHeight>',
    '<MatrixWidth>4</MatrixWidth><MatrixHeight>4</MatrixHeight></TileMatrix>',
  ];
  const xml = [
    '<?xml version="1.0"?><Capabilities><Contents><Layer><ows:Identifier>a</ows:Identifier>',
    '<ResourceURL format="image/jpeg" resourceType="tile" ',
    'template="https://h.example/{TileMatrix}"/></Layer>',
    '<TileMatrixSet><ows:Identifier>s</ows:Identifier>',
    '<ows:SupportedCRS>urn:ogc:def:crs:EPSG::3794</ows:SupportedCRS>',
    ...matrix,
    '</TileMatrixSet></Contents></Capabilities>',
  ].join('');
  const good = [Buffer.from(xml)];
  return target('capabilities', 600, damagedOneOf(1), async (input) => {
    const wanted = { layer: 'a', matrixSet: 's', format: 'image/jpeg', axis: 'en' } as const;
    const text = arrived(good, input).toString('utf8');
    const service = await acceptedOrRefused(['MAP_SERVICE'], () =>
      parseCapabilities(text, 'https://h.example/wmts', wanted),
    );
    for (const { resolution_m, columns, rows, tile_px } of service?.matrices ?? []) {
      assert.ok(resolution_m > 0 && [columns, rows, tile_px].every(Number.isInteger));
    }
  });
}

/** All of them; files they need are made here, except those that need GDAL. */
export function allTargets(): Target[] {
  return [
    ...lasTargets(),
    zipTarget(),
    ...geometryTargets(),
    storeTarget(),
    ...httpTargets(),
    ...tomlTargets(),
    ...replyTargets(),
    capabilitiesTarget(),
    ...vectorTargets(),
  ];
}
