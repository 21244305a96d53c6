import assert from 'node:assert/strict';
import { link, mkdir, readFile, readdir, stat, symlink, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { setTimeout as delay } from 'node:timers/promises';
import { sendFile, sendPart, sendRest, serve } from '../support/http-fixture.js';
import { makeLaz } from '../support/las-fixture.js';
import {
  fetchFixture,
  kName,
  leavePart,
  makeSquare,
  storedFiles,
  temporaryFolder,
} from '../support/store-fixture.js';

const kLaz = makeLaz({ dataBytes: 300_000 });
const kEtag = '"v1"';
const kPart = 'lidar/test/.462_101.part';
/** 10 ms each: only what never happens takes minutes. */
const kTries = 30_000;

test('the first bytes and how to continue are on the disk before the next arrive', async (t) => {
  // The second comes in two pieces, the later of which may wait for more.
  for (const [first, least] of [
    [1000, 1000],
    [100_000, 1],
  ] as const) {
    await t.test(`${first} bytes`, async (t) => {
      let here: { bytes: number; state: string } | undefined;
      const look = async (root: string): Promise<void> => {
        const bytesHere = async (): Promise<number> =>
          (await stat(join(root, kPart)).catch(() => undefined))?.size ?? 0;
        for (let tries = 0; tries < kTries && (await bytesHere()) < least; ++tries) await delay(10);
        here = {
          bytes: await bytesHere(),
          state: await readFile(join(root, `${kPart}.json`), 'utf8'),
        };
        server.cut();
      };
      const server = await serve(t, (_request, response) =>
        sendPart(response, kLaz, first, { etag: kEtag }),
      );
      // Looked at after the piece was taken, while the server is silent and the program only waits.
      const fixture = await fetchFixture(t, server.base, {
        retries: 0,
        onStored: (bytes) => void (bytes === first && void look(fixture.root)),
      });
      await fixture.fetch([makeSquare(kName, [`${server.base}/a.laz`])]);
      assert.ok((here?.bytes ?? 0) >= least, `${here?.bytes} bytes`);
      assert.deepEqual(JSON.parse(here?.state ?? ''), {
        url: `${server.base}/a.laz`,
        if_range: kEtag,
        total_bytes: kLaz.length,
      });
    });
  }
});

test('a file whose bytes are all here is not requested again if its length is known', async (t) => {
  const server = await serve(t, (_request, response) => sendFile(response, kLaz));
  const fixture = await fetchFixture(t, server.base);
  const url = `${server.base}/a.laz`;
  await leavePart(fixture.root, kLaz, { url, if_range: null, total_bytes: kLaz.length });
  assert.equal((await fixture.fetch([makeSquare(kName, [url])]))[0]?.state, 'verified');
  assert.equal(server.seen.length, 0);
  assert.deepEqual(await storedFiles(fixture.root), ['lidar/test/462_101.laz']);
});

test('a file of unknown length is complete when the server has no rest of it', async (t) => {
  const length = kLaz.length;
  const cases: [name: string, etag: string, range: string, requests: number][] = [
    ['the same file', kEtag, `bytes */${length}`, 1],
    ['another file of that length', '"v2"', `bytes */${length}`, 2],
    ['a shorter file', kEtag, `bytes */${length - 1}`, 2],
  ];
  for (const [name, etag, range, requests] of cases) {
    await t.test(name, async (t) => {
      const server = await serve(t, (request, response) => {
        if (request.headers.range === undefined) return sendFile(response, kLaz, { etag });
        response.writeHead(416, { etag, 'content-range': range }).end();
      });
      const fixture = await fetchFixture(t, server.base);
      const url = `${server.base}/a.laz`;
      await leavePart(fixture.root, kLaz, { url, if_range: kEtag, total_bytes: null });
      assert.equal((await fixture.fetch([makeSquare(kName, [url])]))[0]?.state, 'verified');
      assert.equal(server.seen.length, requests);
      assert.equal(server.seen[0]?.headers.range, `bytes=${kLaz.length}-`);
      assert.deepEqual(await readFile(join(fixture.root, 'lidar/test/462_101.laz')), kLaz);
    });
  }
});

test('a link where an unfinished file belongs is not followed', async (t) => {
  const kinds = { symbolic: symlink, hard: link };
  for (const [kind, make] of Object.entries(kinds)) {
    for (const place of [kPart, `${kPart}.json`]) {
      await t.test(`${kind}, ${place}`, async (t) => {
        const server = await serve(t, (request, response, index) =>
          index === 0
            ? sendPart(response, kLaz, 100_000, { etag: kEtag })
            : sendRest(request, response, kLaz, kEtag),
        );
        const fixture = await fetchFixture(t, server.base, {
          onStored: (bytes) => (bytes === 100_000 ? server.cut() : undefined),
        });
        const precious = join(await temporaryFolder(t), 'precious');
        await writeFile(precious, 'precious');
        await mkdir(join(fixture.root, 'lidar/test'), { recursive: true });
        await make(precious, join(fixture.root, place));
        assert.equal(
          (await fixture.fetch([makeSquare(kName, [`${server.base}/a.laz`])]))[0]?.state,
          'verified',
        );
        assert.equal(await readFile(precious, 'utf8'), 'precious');
        assert.deepEqual(await readFile(join(fixture.root, 'lidar/test/462_101.laz')), kLaz);
        assert.deepEqual(await storedFiles(fixture.root), ['lidar/test/462_101.laz']);
      });
    }
  }
});

test('a link in place of an unfinished file is neither continued nor kept', async (t) => {
  const server = await serve(t, (request, response) => sendRest(request, response, kLaz, kEtag));
  const fixture = await fetchFixture(t, server.base);
  const url = `${server.base}/a.laz`;
  const elsewhere = await temporaryFolder(t);
  await writeFile(join(elsewhere, 'whole'), Buffer.from(kLaz).fill(7, 400));
  const state = { url, if_range: kEtag, total_bytes: kLaz.length };
  await leavePart(fixture.root, undefined, state);
  await symlink(join(elsewhere, 'whole'), join(fixture.root, kPart));
  assert.equal((await fixture.fetch([makeSquare(kName, [url])]))[0]?.state, 'verified');
  assert.deepEqual(await readFile(join(fixture.root, 'lidar/test/462_101.laz')), kLaz);
  assert.deepEqual(await readdir(elsewhere), ['whole']);
});

test('a body of unknown length stops when the disk is full, while it comes', async (t) => {
  const server = await serve(t, (_request, response) => {
    response.writeHead(200, { etag: kEtag });
    const more = (): void => {
      if (!response.destroyed && response.write(kLaz)) setImmediate(more);
      else response.once('drain', more);
    };
    more();
  });
  // The room is there when the body begins, and a while later others have taken it.
  let queries = 0;
  const fixture = await fetchFixture(t, server.base, {
    retries: 0,
    freeBytes: () => {
      queries += 1;
      return 1024 ** 2 * (queries <= 3 ? 600 : 200);
    },
  });
  await assert.rejects(fixture.fetch([makeSquare(kName, [`${server.base}/a.laz`])]), {
    code: 'DISK_FULL',
  });
});
