import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test, type TestContext } from 'node:test';
import { sendFile, sendPart, sendRest, serve } from '../support/http-fixture.js';
import { makeLas, makeLaz, makeZip, type ZipMember } from '../support/las-fixture.js';
import { computeSha256 } from '../support/record-fixture.js';
import type { Outcome } from '../../../grabber/src/progress/reporter.js';
import {
  fetchFixture,
  kName,
  makeSquare,
  storedFiles,
  type Fixture,
} from '../support/store-fixture.js';

const kLaz = makeLaz({ dataBytes: 200_000 });
const kZip = makeZip([{ name: 'a.laz', data: kLaz }]);
/** An archive with one wrong field. */
const wrong = (field: Partial<ZipMember>): Buffer =>
  makeZip([{ name: 'a.laz', data: kLaz, ...field }]);
const kOther = { name: 'readme.txt', data: Buffer.from('hello') };

const kTaken: [name: string, zip: Buffer, member: string][] = [
  ['the only point cloud', makeZip([kOther, { name: 'a/TM_462_101.LAZ', data: kLaz }]), '*'],
  [
    'the named one of several',
    makeZip([
      { name: 'b.laz', data: makeLas() },
      { name: 'deep/A.laz', data: kLaz },
    ]),
    'a.laz',
  ],
];

const kMost_bytes = 90_000_000;
const kLarge = wrong({ claimedBytes: kMost_bytes + 1 });
const kSeveral = makeZip([
  { name: 'a.laz', data: kLaz },
  { name: 'b.las', data: kLaz },
]);
const kRefused: [name: string, zip: Buffer, code: string, message: RegExp][] = [
  [
    'several and none named',
    kSeveral,
    'ARCHIVE',
    /2 point clouds among 2 members; allowed: exactly/,
  ],
  ['none', makeZip([kOther]), 'ARCHIVE', /0 point clouds among 1 members/],
  ['a name that leads out', wrong({ name: '../../evil.laz' }), 'ARCHIVE', /invalid relative path/],
  ['an absolute name', wrong({ name: '/tmp/evil.laz' }), 'ARCHIVE', /absolute path/],
  ['a wrong checksum', wrong({ crc: 1 }), 'ARCHIVE', /CRC is [0-9a-f]+; allowed: 1$/],
  ['encrypted', wrong({ flags: 1 }), 'ARCHIVE', /encrypted/],
  ['an unknown compression', wrong({ method: 93 }), 'ARCHIVE', /compression method 93/],
  ['more than its header states', wrong({ claimedBytes: 1000 }), 'ARCHIVE', /too many bytes/],
  ['less than it states', wrong({ claimedBytes: 9e6 }), 'ARCHIVE', /not enough bytes/],
  [
    'a bomb',
    wrong({ data: Buffer.alloc(80_000_000) }),
    'TOO_LARGE',
    /80000000; allowed: 100 times/,
  ],
  ['beyond the size limit', kLarge, 'TOO_LARGE', /allowed: 90000000/],
  ['no archive at all', kLaz, 'ARCHIVE', /central directory/],
  ['cut off', kZip.subarray(0, -30), 'ARCHIVE', /./],
  ['a member that is no point cloud', wrong({ data: Buffer.alloc(5000) }), 'NOT_LAS', /./],
];

async function fetchZip(t: TestContext, zip: Buffer, member = '*'): Promise<[Fixture, Outcome]> {
  const server = await serve(t, (_request, response) => sendFile(response, zip, { etag: '"z"' }));
  const fixture = await fetchFixture(t, server.base, {
    retries: 1,
    job: { max_bytes: kMost_bytes },
  });
  const known = { member, sha256: computeSha256(zip), bytes: zip.length };
  const [outcome] = await fixture.fetch([makeSquare(kName, [`${server.base}/a.zip`], known)]);
  assert.ok(outcome);
  return [fixture, outcome];
}

test('the point cloud of an archive is unpacked and stored as itself', async (t) => {
  for (const [name, zip, member] of kTaken) {
    const [fixture, outcome] = await fetchZip(t, zip, member);
    assert.equal(outcome.state, 'verified', `${name}: ${JSON.stringify(outcome)}`);
    assert.deepEqual(await storedFiles(fixture.root), ['lidar/test/462_101.laz']);
    assert.deepEqual(await readFile(join(fixture.root, 'lidar/test/462_101.laz')), kLaz);
  }
});

test('an archive that cannot be trusted is refused, and leaves no file', async (t) => {
  for (const [name, zip, code, message] of kRefused) {
    await t.test(name, async (t) => {
      const [fixture, outcome] = await fetchZip(t, zip);
      assert.ok(outcome.state === 'failed', JSON.stringify(outcome));
      assert.equal(outcome.code, code);
      assert.match(outcome.message, message);
      const files = await storedFiles(fixture.root);
      assert.deepEqual(
        files.filter((file) => /\.zip|\d\.la/.test(file)),
        [],
      );
    });
  }
});

test('an archive that broke off continues where it stopped', async (t) => {
  const zip = wrong({ stored: true });
  const server = await serve(t, (request, response, index) =>
    index === 0
      ? sendPart(response, zip, 90_000, { etag: '"z"' })
      : sendRest(request, response, zip, '"z"'),
  );
  const fixture = await fetchFixture(t, server.base, {
    onStored: (bytes) => (bytes === 90_000 ? server.cut() : undefined),
  });
  const [outcome] = await fixture.fetch([
    makeSquare(kName, [`${server.base}/a.zip`], { member: '*' }),
  ]);
  assert.equal(outcome?.state, 'verified');
  assert.equal(server.seen[1]?.headers.range, 'bytes=90000-');
});
