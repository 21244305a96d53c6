import assert from 'node:assert/strict';
import { test } from 'node:test';
import { LevelCut } from '../../voxelserver/serve/page/src/viewer/draw/level-cut.js';
import { toCamera } from '../../voxelserver/serve/page/src/viewer/ui/navigation.js';
import { along } from '../../voxelserver/serve/page/src/vec3.js';
import { ViewCut } from '../../voxelserver/serve/page/src/viewer/view-cut.js';

const kBounds = { min: [-2048, 0, -2048], max: [2048, 256, 2048] } as const;
const kSide = 64;

/** From the middle of the world, to the east unless told otherwise. */
function makeCut(headingDeg: number, pitchDeg: number, aspect = 1) {
  const position = [30, 128, 30] as const;
  const camera = toCamera({ position, headingDeg, pitchDeg, fovDeg: 60 });
  const view = { eye: position, pixelRad: 0.002, detail: 8 };
  const plain = new LevelCut(kBounds, view, 6);
  return { camera, plain, cut: new ViewCut(kBounds, view, 6, camera, aspect) };
}

test('columns are in view exactly where a ray of the picture may meet them', () => {
  for (const [heading, pitch, aspect] of [
    [90, 0, 1],
    [200, -20, 16 / 9],
    [-45, 10, 0.5],
    [30, -89, 1],
  ] as const) {
    const { camera, cut } = makeCut(heading, pitch, aspect);
    // Whatever a ray of the picture passes within the world must count as in view.
    for (let i = 0; i <= 10; ++i) {
      for (let j = 0; j <= 10; ++j) {
        const [across, upward] = [aspect * (i / 5 - 1), j / 5 - 1];
        const ray = along(camera.forward, [camera.right, across], [camera.up, upward]);
        for (let t = 5; t < 2000; t += 40) {
          const point = along(camera.position, [ray, t]);
          const [x, y, z] = point;
          if (y < 0 || y > 256) break;
          const where = `heading ${heading}, pitch ${pitch}, ${point.join(' ')}`;
          assert.ok(cut.isInView(0, Math.floor(x / kSide), Math.floor(z / kSide)), where);
        }
      }
    }
  }
});

test('what is out of view is as coarse as can be, what is in view as in the tracer', () => {
  const { plain, cut } = makeCut(90, 0);
  const counts = { finer: 0, out: 0 };
  for (let bx = -32; bx < 32; ++bx) {
    for (let bz = -32; bz < 32; ++bz) {
      const isOut = !cut.isInView(1, bx, bz);
      counts.out += Number(isOut);
      counts.finer += Number(!plain.isFarEnough(1, bx, bz) && isOut);
      assert.equal(cut.isFarEnough(1, bx, bz), isOut || plain.isFarEnough(1, bx, bz));
    }
  }
  // To the east, with 60 degrees: far more than half of the world is out of view.
  assert.ok(counts.out > 64 * 64 * 0.7 && counts.out < 64 * 64 * 0.9, `${counts.out}`);
  assert.ok(counts.finer > 0);
  assert.ok(cut.isInView(0, 10, 0) && !cut.isInView(0, -10, 0) && !cut.isInView(0, 0, 20));
});
