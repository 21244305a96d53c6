import assert from 'node:assert/strict';
import { test } from 'node:test';
import { kFilePath, kPlaces } from '../../../grabber/src/store/layout.js';
import { keyOfSquare } from '../support/record-fixture.js';

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
  for (const name of [
    '',
    '.',
    '..',
    '../a',
    'a/b',
    '/a',
    'a\\b',
    '.a',
    'a\0b',
    'a\nb',
    'a\u0085b',
    'x'.repeat(201),
  ]) {
    const shown = JSON.stringify(name);
    for (const key of [
      keyOfSquare(name),
      keyOfSquare('a', name, 'g'),
      keyOfSquare('a', 's', name),
    ]) {
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
  for (const path of [
    'lidar/a.laz',
    'lidar/a/b/c.laz',
    'ortho/a/b.laz',
    '/lidar/a/b.laz',
    'lidar/a/b.laz\n',
    'lidar/../b.laz',
    'lidar/a/b.lazx',
  ]) {
    assert.doesNotMatch(path, kFilePath.lidar.pattern, path);
  }
});
