import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { sendFile, sendPart, sendRest, serve } from '../support/http-fixture.js';
import { makeLas, makeLaz } from '../support/las-fixture.js';
import {
  fetchFixture,
  kName,
  squareOf,
  storedFiles,
  type FixtureOptions,
} from '../support/store-fixture.js';
import { makeZip } from '../support/zip-fixture.js';

const kLaz = makeLaz({ dataBytes: 200_000 });
const kOther = { name: 'readme.txt', data: Buffer.from('hello') };

type Case = {
  name: string;
  zip: Buffer;
  member?: string;
  options?: FixtureOptions;
  code?: string;
  message?: RegExp;
};

const kCases: Case[] = [
  {
    name: 'the only point cloud',
    zip: makeZip([kOther, { name: 'a/TM_462_101.LAZ', data: kLaz }]),
  },
  {
    name: 'stored without compression',
    zip: makeZip([{ name: 'x.laz', data: kLaz, stored: true }]),
  },
  {
    name: 'the named one of several',
    zip: makeZip([
      { name: 'b.laz', data: makeLas() },
      { name: 'deep/A.laz', data: kLaz },
    ]),
    member: 'a.laz',
  },
  {
    name: 'several and none named',
    zip: makeZip([
      { name: 'a.laz', data: kLaz },
      { name: 'b.las', data: kLaz },
    ]),
    code: 'ARCHIVE',
    message: /2 point clouds among 2 members; allowed: exactly one/,
  },
  {
    name: 'none',
    zip: makeZip([kOther]),
    code: 'ARCHIVE',
    message: /0 point clouds among 1 members/,
  },
  {
    name: 'a name that leads out',
    zip: makeZip([{ name: '../../evil.laz', data: kLaz }]),
    code: 'ARCHIVE',
    message: /invalid relative path/,
  },
  {
    name: 'an absolute name',
    zip: makeZip([{ name: '/tmp/evil.laz', data: kLaz }]),
    code: 'ARCHIVE',
    message: /absolute path/,
  },
  {
    name: 'a wrong checksum',
    zip: makeZip([{ name: 'a.laz', data: kLaz, crc: 1 }]),
    code: 'ARCHIVE',
    message: /CRC is [0-9a-f]+; allowed: 1$/,
  },
  {
    name: 'encrypted',
    zip: makeZip([{ name: 'a.laz', data: kLaz, flags: 1 }]),
    code: 'ARCHIVE',
    message: /encrypted/,
  },
  {
    name: 'an unknown compression',
    zip: makeZip([{ name: 'a.laz', data: kLaz, method: 93 }]),
    code: 'ARCHIVE',
    message: /compression method 93/,
  },
  {
    name: 'more than its header states',
    zip: makeZip([{ name: 'a.laz', data: kLaz, claimedBytes: 1000 }]),
    code: 'ARCHIVE',
    message: /too many bytes/,
  },
  {
    name: 'less than its header states',
    zip: makeZip([{ name: 'a.laz', data: kLaz, claimedBytes: kLaz.length + 5 }]),
    code: 'ARCHIVE',
    message: /not enough bytes/,
  },
  {
    name: 'a bomb with its true size',
    zip: makeZip([{ name: 'a.laz', data: Buffer.alloc(80_000_000) }]),
    code: 'TOO_LARGE',
    message: /have grown to 80000000; allowed: 100 times/,
  },
  {
    name: 'beyond the size limit',
    zip: makeZip([{ name: 'a.laz', data: kLaz }]),
    options: { job: { max_bytes: 150_000 } },
    code: 'TOO_LARGE',
    message: /allowed: 150000/,
  },
  { name: 'no archive at all', zip: kLaz, code: 'ARCHIVE', message: /central directory/ },
  {
    name: 'cut off',
    zip: makeZip([{ name: 'a.laz', data: kLaz }]).subarray(0, -30),
    code: 'ARCHIVE',
  },
  {
    name: 'a member that is no point cloud',
    zip: makeZip([{ name: 'a.laz', data: Buffer.alloc(5000) }]),
    code: 'NOT_LAS',
  },
];

test('the point cloud of an archive is unpacked and stored as itself', async (t) => {
  for (const { name, zip, member, options, code, message } of kCases) {
    await t.test(name, async (t) => {
      const server = await serve(t, (_request, response) =>
        sendFile(response, zip, { etag: '"z"' }),
      );
      const fixture = await fetchFixture(t, server.base, { retries: 1, ...options });
      const sha256 = createHash('sha256').update(zip).digest('hex');
      const [outcome] = await fixture.fetch([
        squareOf(kName, [`${server.base}/a.zip`], {
          member: member ?? '*',
          sha256,
          bytes: zip.length,
        }),
      ]);
      if (code === undefined) {
        assert.equal(outcome?.state, 'verified', JSON.stringify(outcome));
        assert.deepEqual(await storedFiles(fixture.root), ['lidar/test/462_101.laz']);
        assert.deepEqual(await readFile(join(fixture.root, 'lidar/test/462_101.laz')), kLaz);
        return;
      }
      assert.equal(
        outcome?.state === 'failed' ? outcome.code : undefined,
        code,
        JSON.stringify(outcome),
      );
      assert.match(outcome?.state === 'failed' ? outcome.message : '', message ?? /./);
      assert.deepEqual(
        (await storedFiles(fixture.root)).filter((file) => /\.zip|\d\.la/.test(file)),
        [],
      );
    });
  }
});

test('an archive that broke off continues where it stopped', async (t) => {
  const zip = makeZip([{ name: 'a.laz', data: kLaz, stored: true }]);
  const server = await serve(t, (request, response, index) =>
    index === 0
      ? sendPart(response, zip, 90_000, { etag: '"z"' })
      : sendRest(request, response, zip, '"z"'),
  );
  const fixture = await fetchFixture(t, server.base, {
    onStored: (bytes) => (bytes === 90_000 ? server.cut() : undefined),
  });
  const [outcome] = await fixture.fetch([
    squareOf(kName, [`${server.base}/a.zip`], { member: '*' }),
  ]);
  assert.equal(outcome?.state, 'verified');
  assert.equal(server.seen[1]?.headers.range, 'bytes=90000-');
});
