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
