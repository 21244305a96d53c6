import assert from 'node:assert/strict';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import * as fc from 'fast-check';
import { parsePointCount } from '../../../../grabber/src/convert/zlas.js';
import { DiskSpace } from '../../../../grabber/src/fetch/disk-space.js';
import { unzipMember } from '../../../../grabber/src/fetch/zip-member.js';
import { kHeaderReadBytes, readLasHeader } from '../../../../grabber/src/las/header.js';
import { verifyLasFile } from '../../../../grabber/src/las/verify.js';
import { fakeClock, kNever } from '../../support/store-fixture.js';
import { makeLas, makeLaz, makeZip } from '../../support/las-fixture.js';
import { arrived, arbitraryDamage } from '../damage.js';
import { acceptedOrRefused, type Target, files, kFolder, target } from './target.js';

const kDisk = {
  disk: new DiskSpace(tmpdir(), () => 2 ** 40),
  clock: fakeClock(),
  max_bytes: 64 * 1024 * 1024,
};

export function lasTargets(): Target[] {
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
    fc.tuple(arbitraryDamage(good.length), fc.maxSafeNat()),
    async ([input, size]) => {
      const start = arrived(good, input).subarray(0, kHeaderReadBytes);
      parsePointCount(start);
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

export function zipTarget(): Target {
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
