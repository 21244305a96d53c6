import assert from 'node:assert/strict';
import { test } from 'node:test';
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { kFilePath, kPlaces } from '../../../grabber/src/store/layout.js';
import { keyOfSquare, readRing } from '../support/record-fixture.js';
import { lockStore } from '../../../grabber/src/store/open-store.js';
import { makeFolder } from '../../../grabber/src/util/files.js';
import { kNever, temporaryFolder } from '../support/store-fixture.js';
import { encodeFootprint } from '../../../grabber/src/store/geometry.js';

test('files lie by source, orthophotos also by grid, and unfinished files are hidden', () => {
  const square = keyOfSquare('462_101');
  const ortho = keyOfSquare('462_101', 'si-dof', 'si-lss');
  assert.equal(kPlaces.finished('lidar', square, 'laz'), 'lidar/si-lss/462_101.laz');
  assert.equal(kPlaces.finished('lidar', square, 'zlas'), 'lidar/si-lss/462_101.zlas');
  assert.equal(kPlaces.unfinished('lidar', square), 'lidar/si-lss/.462_101.part');
  assert.equal(kPlaces.finished('ortho', ortho, 'tif'), 'ortho/si-dof/si-lss/462_101.tif');
  assert.equal(kPlaces.unfinished('ortho', ortho), 'ortho/si-dof/si-lss/.462_101.part');
  assert.match(
    kPlaces.finished('lidar', keyOfSquare('Ljubljana – Šiška (2)'), 'las'),
    kFilePath.lidar.pattern,
  );
});

test('no name leads out of its folder', () => {
  const conflict = { code: 'STORE_CONFLICT' };
  const outside = ['', '.', '..', '../a', 'a/b', '/a', 'a\\b', '.a', 'a\0b', 'a\nb', 'a\u0085b'];
  for (const name of [...outside, 'x'.repeat(201)]) {
    const shown = JSON.stringify(name);
    const parts = [[name], ['a', name, 'g'], ['a', 's', name]] as const;
    for (const [of, source, grid] of parts) {
      const key = keyOfSquare(of, source, grid);
      assert.throws(() => kPlaces.finished('ortho', key, 'tif'), conflict, shown);
      assert.throws(() => kPlaces.unfinished('ortho', key), conflict, shown);
    }
    assert.doesNotMatch(
      `lidar/si-lss/${name}.laz`,
      name.length > 200 ? /never/ : kFilePath.lidar.pattern,
      shown,
    );
  }
  for (const extension of ['', 'exe', 'laz/..', 'tif']) {
    assert.throws(() => kPlaces.finished('lidar', keyOfSquare('a'), extension), conflict);
  }
  const paths = 'lidar/a.laz lidar/a/b/c.laz ortho/a/b.laz /lidar/a/b.laz lidar/../b.laz'.split(
    ' ',
  );
  for (const path of [...paths, 'lidar/a/b.laz\n', 'lidar/a/b.lazx']) {
    assert.doesNotMatch(path, kFilePath.lidar.pattern, path);
  }
});

const kModule = new URL('../../../grabber/src/store/open-store.js', import.meta.url).href;

test('a store has one grabber at a time', async (t) => {
  const path = join(await temporaryFolder(t), '.lock');
  const unlock = lockStore(path, kNever);
  assert.throws(() => lockStore(path, kNever), {
    code: 'STORE_LOCKED',
    message: /another grabber holds .*\.lock; allowed: one/,
  });
  unlock();
  lockStore(path, kNever)();
});

test('a killed process leaves no lock, and an empty file is none', async (t) => {
  const path = join(await temporaryFolder(t), '.lock');
  await writeFile(path, '');
  const script =
    `const { lockStore } = await import(${JSON.stringify(kModule)}); globalThis.unlock = ` +
    `lockStore(${JSON.stringify(path)}, new AbortController().signal); console.log('held'); ` +
    'setInterval(() => {}, 1000);';
  const child = spawn(process.execPath, ['--input-type=module', '--eval', script], {
    cwd: fileURLToPath(new URL('.', import.meta.url)),
  });
  t.after(() => child.kill('SIGKILL'));
  await once(child.stdout, 'data');
  assert.throws(() => lockStore(path, kNever), { code: 'STORE_LOCKED' });
  child.kill('SIGKILL');
  await once(child, 'exit');
  lockStore(path, kNever)();
});

test('a folder is made with its parents, and the attempt ends where it cannot be', async (t) => {
  const root = await temporaryFolder(t);
  await makeFolder(join(root, 'a', 'b', 'c'));
  await makeFolder(join(root, 'a', 'b', 'c'));
  await writeFile(join(root, 'file'), '');
  await assert.rejects(makeFolder(join(root, 'file')), { code: 'EEXIST' });
  await assert.rejects(makeFolder(join(root, 'file', 'below')), { code: 'ENOTDIR' });
  await assert.rejects(makeFolder('/proc/no-such-process/x'), { code: 'ENOENT' });
});

/**
 * South-west corners as PROJ has them, by gdaltransform. A tenth of an arc second is three metres.
 */
const kCorners: readonly {
  crs: string;
  corner: readonly [number, number];
  degrees: readonly [number, number];
}[] = [
  { crs: 'EPSG:3794', corner: [462_000, 101_000], degrees: [14.508973, 46.047744] },
  { crs: 'EPSG:28992', corner: [85_000, 446_000], degrees: [4.36788777930765, 51.9979621078331] },
];

test('squares lie on the map where PROJ has them', () => {
  for (const { crs, corner, degrees } of kCorners) {
    const [west, south] = corner;
    const blob = encodeFootprint([west, south, west + 1000, south + 1000], crs);
    assert.ok(blob, crs);
    const [longitude, latitude] = readRing(blob)[0] ?? [0, 0];
    assert.ok(
      Math.abs(longitude - degrees[0]) < 3e-5 && Math.abs(latitude - degrees[1]) < 3e-5,
      `${crs}: ${longitude} ${latitude}`,
    );
  }
});

test('ground in a CRS without a known projection has no polygon', () => {
  for (const crs of ['EPSG:999999', 'EPSG:4326', 'here', null]) {
    assert.equal(encodeFootprint([0, 0, 1, 1], crs), null);
  }
  assert.equal(encodeFootprint(null, 'EPSG:3794'), null);
});
