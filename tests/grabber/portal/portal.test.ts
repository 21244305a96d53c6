import assert from 'node:assert/strict';
import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test, type TestContext } from 'node:test';
import { kFaults, parseFaults, type Fault } from './faults.js';
import { startPortal, type Portal, type PortalOptions } from './portal.js';
import { blockOf } from './squares.js';
import { makeLaz } from '../support/las-fixture.js';
import { sha256Of } from '../support/record-fixture.js';
import {
  fetchFixture,
  keyOf,
  leavePart,
  squareOf,
  temporaryFolder,
} from '../support/store-fixture.js';

function lazOf(east: number, north: number, dataBytes: number): Buffer {
  const [x, y] = [east * 1000, north * 1000];
  return makeLaz({ dataBytes, min: [x, y, 280], max: [x + 999, y + 999, 540] });
}

async function portalOf(
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
      lazOf(460 + index, 101, dataBytes),
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
      const portal = await portalOf(t, 6, fault === 'slow' ? 3000 : 200_000, {
        faults: parseFaults(`${fault}=0.5`),
        seed: 3,
      });
      const fixture = await fetchFixture(t, portal.base, {
        retries: 12,
        timeout_ms: fault === 'stall' ? 300 : 20_000,
      });
      const names = portal.context.squares.map(({ name }) => name);
      await fixture.fetch(
        portal.context.squares.map(({ name, path }) => squareOf(name, [`${portal.base}/${path}`])),
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
        assert.equal(record.file?.sha256, sha256Of(body));
      }
    });
  }
});

test('a file continues from any byte', async (t) => {
  const portal = await portalOf(t, 1, 60_000);
  const url = `${portal.base}/laz/TM_460_101.laz`;
  const body = await readFile(join(portal.context.root, 'laz', 'TM_460_101.laz'));
  const { etag } = Object.fromEntries((await fetch(url, { method: 'HEAD' })).headers);
  for (const offset of [1, 226, 30_000, body.length - 1, body.length]) {
    await t.test(`at ${offset} of ${body.length}`, async (t) => {
      const fixture = await fetchFixture(t, portal.base);
      const state = { url, if_range: etag ?? null, total_bytes: body.length };
      await leavePart(fixture.root, body.subarray(0, offset), state, '460_101');
      const before = portal.context.stats.of('/laz/TM_460_101.laz').bytes;
      await fixture.fetch([squareOf('460_101', [url])]);
      assert.equal(
        portal.context.stats.of('/laz/TM_460_101.laz').bytes - before,
        body.length - offset,
      );
      assert.equal(fixture.store.squares.get(keyOf('460_101'))?.file?.sha256, sha256Of(body));
    });
  }
});

type StacPage = {
  readonly features: readonly {
    readonly id: string;
    readonly bbox: readonly [number, number, number, number];
    readonly assets: Readonly<Record<string, { readonly 'file:size': number }>>;
  }[];
  readonly links: readonly { readonly rel: string; readonly href: string }[];
};
type WfsPage = {
  readonly features: readonly { readonly properties: { readonly ti_name: string } }[];
};
type Stats = Readonly<Record<string, { readonly whole: number }>>;

test('the portal answers as real portals do', async (t) => {
  const portal = await portalOf(t, 5, 2000);
  const json = async <T>(path: string): Promise<T> =>
    (await (await fetch(`${portal.base}${path}`)).json()) as T;

  const [first] = portal.context.squares;
  assert.equal(first?.block, blockOf(460, 101));
  const listing = await (await fetch(`${portal.base}/lidar/gkot/laz/${first.block}/D96TM/`)).text();
  assert.match(listing, /TM_460_101\.laz/);
  const file = await fetch(`${portal.base}/lidar/gkot/laz/${first.block}/D96TM/TM_460_101.laz`);
  assert.equal((await file.arrayBuffer()).byteLength, first.bytes);
  assert.equal(
    (await fetch(`${portal.base}/lidar/gkot/laz/b_37/D96TM/TM_460_101.laz`)).status,
    404,
  );

  const page = await json<StacPage>('/stac/v1/collections/squares/items?limit=3');
  assert.equal(page.features.length, 3);
  const next = page.links.find((link) => link.rel === 'next')?.href ?? '';
  const rest = (await (await fetch(next)).json()) as StacPage;
  assert.deepEqual(
    [...page.features, ...rest.features].map((item) => item.id),
    [460, 461, 462, 463, 464].map((e) => `squares_2024_${e}-101`),
  );
  const [item] = page.features;
  assert.equal(item?.assets['TM_460_101.laz']?.['file:size'], first.bytes);
  const [west, south] = item.bbox;
  assert.ok(west > 13 && west < 17 && south > 45 && south < 47, 'lies in Slovenia');
  assert.equal(
    (await json<StacPage>(`/stac/v1/collections/squares/items?bbox=${item.bbox.join(',')}`))
      .features.length,
    2,
    'a turned square touches its neighbour',
  );

  const features = await json<WfsPage>(
    '/wfs?service=WFS&version=2.0.0&request=GetFeature&count=2&startIndex=1' +
      '&outputFormat=application/json',
  );
  assert.deepEqual(
    features.features.map((one) => one.properties.ti_name),
    ['461_101', '462_101'],
  );
  assert.equal(
    (await json<WfsPage>('/wfs?request=GetFeature&bbox=461000,101000,462000,102000,EPSG:3794'))
      .features.length,
    1,
  );
  assert.match(await (await fetch(`${portal.base}/wfs?request=Nothing`)).text(), /ExceptionReport/);
  assert.equal(
    (await json<Stats>('/stats'))[`/lidar/gkot/laz/${first.block}/D96TM/TM_460_101.laz`]?.whole,
    1,
  );
  assert.equal((await fetch(`${portal.base}/%2e%2e/%2e%2e/etc/passwd`)).status, 404);
});
