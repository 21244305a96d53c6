import assert from 'node:assert/strict';
import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test, type TestContext } from 'node:test';
import { kFaults, parseFaults, type Fault, type FileStats } from './faults.js';
import { startPortal, type Portal, type PortalOptions } from './portal.js';
import { makeBlockName } from './squares.js';
import { makeLaz } from '../support/las-fixture.js';
import { computeSha256 } from '../support/record-fixture.js';
import {
  fetchFixture,
  toKey,
  leavePart,
  makeSquare,
  temporaryFolder,
} from '../support/store-fixture.js';

function makeSquareLaz(east: number, north: number, dataBytes: number): Buffer {
  const [x, y] = [east * 1000, north * 1000];
  return makeLaz({ dataBytes, min: [x, y, 280], max: [x + 999, y + 999, 540] });
}

async function openPortal(
  t: TestContext,
  count: number,
  dataBytes: number,
  options: Partial<PortalOptions> = {},
): Promise<Portal> {
  const root = await temporaryFolder(t);
  await mkdir(join(root, 'laz'));
  for (let index = 0; index < count; ++index) {
    await writeFile(
      join(root, 'laz', `TM_${460 + index}_101.laz`),
      makeSquareLaz(460 + index, 101, dataBytes),
    );
  }
  const portal = await startPortal({ root, ...options });
  t.after(() => portal.close());
  return portal;
}

test('every fault of a portal ends as it should', async (t) => {
  const failing: Partial<Record<Fault, string>> = { foreign: 'HOST_REFUSED' };
  for (const fault of kFaults) {
    await t.test(fault, async (t) => {
      const portal = await openPortal(t, 6, fault === 'slow' ? 3000 : 200_000, {
        faults: parseFaults(`${fault}=0.5`),
        seed: 3,
      });
      const fixture = await fetchFixture(t, portal.base, {
        retries: 12,
        timeout_ms: fault === 'stall' ? 300 : 20_000,
      });
      const names = portal.context.squares.map(({ name }) => name);
      await fixture.fetch(
        portal.context.squares.map(({ name, path }) =>
          makeSquare(name, [`${portal.base}/${path}`]),
        ),
      );
      const files = Object.values(portal.context.stats.toJSON());
      assert.ok(
        files.some(({ faults }) => faults > 0),
        'the fault occurred',
      );
      for (const name of names) {
        const record = fixture.record(name);
        if (record?.state === 'failed' && failing[fault] !== undefined) {
          assert.equal(record.lastError?.code, failing[fault]);
          continue;
        }
        assert.equal(record?.state, 'verified', `${name}: ${record?.lastError?.message ?? ''}`);
        const body = await readFile(join(portal.context.root, 'laz', `TM_${name}.laz`));
        assert.equal(record.file?.sha256, computeSha256(body));
      }
    });
  }
});

test('a file continues from any byte', async (t) => {
  const portal = await openPortal(t, 1, 60_000);
  const url = `${portal.base}/laz/TM_460_101.laz`;
  const body = await readFile(join(portal.context.root, 'laz', 'TM_460_101.laz'));
  const { etag } = Object.fromEntries((await fetch(url, { method: 'HEAD' })).headers);
  for (const offset of [1, 226, 30_000, body.length - 1, body.length]) {
    await t.test(`at ${offset} of ${body.length}`, async (t) => {
      const fixture = await fetchFixture(t, portal.base);
      const state = { url, if_range: etag ?? null, total_bytes: body.length };
      await leavePart(fixture.root, body.subarray(0, offset), state, '460_101');
      const before = portal.context.stats.of('/laz/TM_460_101.laz').bytes;
      await fixture.fetch([makeSquare('460_101', [url])]);
      assert.equal(
        portal.context.stats.of('/laz/TM_460_101.laz').bytes - before,
        body.length - offset,
      );
      assert.equal(fixture.store.squares.get(toKey('460_101'))?.file?.sha256, computeSha256(body));
    });
  }
});

test('the portal answers as real portals do', async (t) => {
  const portal = await openPortal(t, 5, 2000);
  type Feature = { id: string; bbox: number[]; properties: Record<string, unknown> };
  type Page = { features: Feature[]; links: { rel: string; href: string }[] };
  const page = async (path: string): Promise<Page> =>
    (await (await fetch(new URL(path, portal.base))).json()) as Page;

  const [first] = portal.context.squares;
  assert.equal(first?.block, makeBlockName(460, 101));
  const folder = `/lidar/gkot/laz/${first.block}/D96TM/`;
  assert.match(await (await fetch(`${portal.base}${folder}`)).text(), /TM_460_101\.laz/);
  const file = await fetch(`${portal.base}${folder}TM_460_101.laz`);
  assert.equal((await file.arrayBuffer()).byteLength, first.bytes);
  for (const none of ['/lidar/gkot/laz/b_37/D96TM/TM_460_101.laz', '/%2e%2e/%2e%2e/etc/passwd']) {
    assert.equal((await fetch(`${portal.base}${none}`)).status, 404, none);
  }
  const stats = (await (await fetch(`${portal.base}/stats`)).json()) as Record<string, FileStats>;
  assert.equal(stats[`${folder}TM_460_101.laz`]?.whole, 1);

  const items = '/stac/v1/collections/squares/items';
  const some = await page(`${items}?limit=3`);
  const rest = await page(some.links.find(({ rel }) => rel === 'next')?.href ?? '');
  assert.deepEqual(
    [...some.features, ...rest.features].map(({ id }) => id),
    [460, 461, 462, 463, 464].map((e) => `squares_2024_${e}-101`),
  );
  const box = some.features[0]?.bbox ?? [];
  // A turned square touches its neighbour.
  assert.equal((await page(`${items}?bbox=${box.join(',')}`)).features.length, 2);

  const query = '/wfs?service=WFS&version=2.0.0&request=GetFeature';
  assert.deepEqual(
    (await page(`${query}&count=2&startIndex=1`)).features.map((one) => one.properties['ti_name']),
    ['461_101', '462_101'],
  );
  const within = await page(`${query}&bbox=461000,101000,462000,102000,EPSG:3794`);
  assert.equal(within.features.length, 1);
  assert.match(await (await fetch(`${portal.base}/wfs?request=Nothing`)).text(), /ExceptionReport/);
});
