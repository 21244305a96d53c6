import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { loadConfigFolder, parseConfig } from '../../../grabber/src/config/toml-file.js';
import { kOrthoKind, orthoHosts } from '../../../grabber/src/ortho/schema.js';
import { makeBlocks, makeTarget } from '../../../grabber/src/ortho/target.js';
import { readPackageInfo } from '../../../grabber/src/util/package-info.js';
import { kNever } from '../support/store-fixture.js';

const kConfig = join(readPackageInfo().root, '..', 'config', 'sources', 'ortho');

test('the configured sources can be read, and each lists its hosts', async () => {
  const sources = await loadConfigFolder(kConfig, kOrthoKind, kNever);
  assert.deepEqual(
    [...sources.keys()],
    [
      'ch-swissimage',
      'de-by-dop',
      'de-nw-dop',
      'fr-bdortho',
      'nl-luchtfoto',
      'si-dof025',
      'us-naip',
    ],
  );
  for (const source of sources.values()) assert.equal(orthoHosts(source).length, 1, source.id);
});

test('a source that cannot work is refused with the field and what it may hold', () => {
  const good =
    'id = "a"\ntitle = "A"\nlicence = "L"\nattribution = "B"\ncrs = ' +
    '"EPSG:3794"\nresolution_m = 0.25\n[access]\nkind = "wms"\nurl = "http://a/"\nlayer = ' +
    '"x"\n';
  assert.equal(parseConfig(good, '/c/a.toml', kOrthoKind).max_concurrent, 4);
  const cases: [string, RegExp][] = [
    [good.replace('0.25', '0'), /resolution_m is 0; allowed: a number from 0\.01/],
    [good.replace('"wms"', '"ftp"'), /access\.kind/],
    [
      good.replace('http://a/', 'file:///etc'),
      /access\.url is "file:\/\/\/etc"; allowed: an http\(s\) address/,
    ],
    [good.replace('layer', 'layers'), /access/],
    [good.replace('3794', 'x'), /crs is "EPSG:x"/],
  ];
  for (const [toml, message] of cases) {
    assert.throws(() => parseConfig(toml, '/c/a.toml', kOrthoKind), message);
  }
});

test('neighbouring squares share the pixels of their margins', () => {
  for (const [step, margin] of [
    [0.25, 20],
    [0.5, 10.3],
    [0.1, 0],
    [2, 1],
  ] as const) {
    const west = makeTarget([462_000, 101_000, 463_000, 102_000], 'EPSG:3794', step, margin);
    const east = makeTarget([463_000, 101_000, 464_000, 102_000], 'EPSG:3794', step, margin);
    const apart = (east.bounds[0] - west.bounds[0]) / step;
    assert.ok(Math.abs(apart - Math.round(apart)) < 1e-6, `${step} ${margin}: ${apart}`);
    assert.ok(
      west.bounds[0] <= 462_000 - margin + 1e-9 && west.bounds[2] >= 463_000 + margin - 1e-9,
    );
    assert.ok(Math.abs(west.width_px * step - (west.bounds[2] - west.bounds[0])) < 1e-6);
  }
  assert.throws(
    () => makeTarget([0, 0, 1000, 1000], 'EPSG:3794', 0.01, 0),
    /100000 x 100000 pixels; allowed: 1 to 20000/,
  );
});

test('blocks cover a target once', () => {
  const target = makeTarget([0, 0, 1000, 700], 'EPSG:3794', 1, 3);
  const seen = new Uint8Array(target.width_px * target.height_px);
  for (const block of makeBlocks(target, 300)) {
    assert.ok(block.width_px <= 300 && block.height_px <= 300);
    for (let y = 0; y < block.height_px; ++y) {
      for (let x = 0; x < block.width_px; ++x) {
        seen[(block.y_px + y) * target.width_px + block.x_px + x]! += 1;
      }
    }
  }
  assert.ok(seen.every((count) => count === 1));
});
