import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { basename, join } from 'node:path';
import * as fc from 'fast-check';
import { parseConfig } from '../../../../grabber/src/config/toml-file.js';
import { parseConverters } from '../../../../grabber/src/convert/converters.js';
import type { HttpClient, HttpResponse } from '../../../../grabber/src/fetch/http-client.js';
import { kOrthoKind } from '../../../../grabber/src/ortho/schema.js';
import { parseCapabilities } from '../../../../grabber/src/ortho/wmts.js';
import { regionOfBox } from '../../../../grabber/src/select/region.js';
import { openCatalogue } from '../../../../grabber/src/sources/catalogue/open-catalogue.js';
import { parseSource } from '../../../../grabber/src/sources/source.js';
import { readPackageInfo } from '../../../../grabber/src/util/package-info.js';
import { sourceWith } from '../../support/catalogue-fixture.js';
import { fakeClock, kNever } from '../../support/store-fixture.js';
import { arrived, arbitraryDamage } from '../damage.js';
import { acceptedOrRefused, makeResponse, type Target, target } from './target.js';

const kConfig = join(readPackageInfo().root, '..', 'config');

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

export function tomlTargets(): Target[] {
  const good = [
    ...['si-lss', 'us-3dep', 'nl-ahn'].map((name) => join(kConfig, 'sources', `${name}.toml`)),
    join(kConfig, 'areas', 'bled.toml'),
    join(kConfig, 'converters.toml'),
  ].map((path) => ({ name: basename(path), text: readFileSync(path) }));
  const damaged = arbitraryDamage(good.length).map((input) => ({ ...good[input.base], input }));
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

/**
 * Replies of catalogues: JSON of any form, and replies that have the right form with values that
 * are not.
 */
export function replyTargets(): Target[] {
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
      const get = (): Promise<HttpResponse> => Promise.resolve(makeResponse(200, {}, answer));
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

export function capabilitiesTarget(): Target {
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
  return target('capabilities', 600, arbitraryDamage(1), async (input) => {
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
