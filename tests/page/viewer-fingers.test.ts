import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { Vec3 } from '../../voxelserver/serve/page/src/vec3.js';
import { fingersMoved, type Fingers } from '../../voxelserver/serve/page/src/viewer/ui/fingers.js';
import { toCamera, type Viewpoint } from '../../voxelserver/serve/page/src/viewer/ui/navigation.js';
import { isNear } from './support/near.js';

const kHeightPx = 600;
const kView: Viewpoint = {
  position: [10, 200, 30],
  headingDeg: 40,
  pitchDeg: -50,
  fovDeg: 45,
};

/** Where a point is in the picture, in halves of its height from the middle: right and up. */
function toViewPlane(view: Viewpoint, point: Vec3): readonly [number, number] {
  const { position, forward, right, up } = toCamera(view);
  const d = [0, 1, 2].map((a) => point[a]! - position[a]!) as unknown as Vec3;
  const dot = (v: Vec3): number => v[0] * d[0] + v[1] * d[1] + v[2] * d[2];
  const share = (v: Vec3): number => dot(v) / (v[0] ** 2 + v[1] ** 2 + v[2] ** 2) / dot(forward);
  return [share(right), share(up)];
}

function ahead(view: Viewpoint, distance: number): Vec3 {
  const { position, forward } = toCamera(view);
  return [0, 1, 2].map((a) => position[a]! + forward[a]! * distance) as unknown as Vec3;
}

const fingersAt = (...c: readonly [number, number, number, number]): Fingers => [
  { x: c[0], y: c[1] },
  { x: c[2], y: c[3] },
];

test('what lies between two fingers follows them', () => {
  const centre = ahead(kView, 150);
  const before = fingersAt(300, 300, 500, 300);
  const follow = (after: Fingers): Viewpoint =>
    fingersMoved(kView, before, after, centre, 150, kHeightPx);
  const far = (view: Viewpoint): number =>
    Math.hypot(...[0, 1, 2].map((a) => centre[a]! - view.position[a]!));

  const along = follow(fingersAt(330, 360, 530, 360));
  const [right, up] = toViewPlane(along, centre);
  isNear(right, 30 / (kHeightPx / 2), 1e-9);
  isNear(up, -60 / (kHeightPx / 2), 1e-9);
  assert.equal(along.headingDeg, kView.headingDeg);

  isNear(far(follow(fingersAt(200, 300, 600, 300))), 75, 1e-9);
  isNear(far(follow(fingersAt(350, 300, 450, 300))), 300, 1e-9);

  // A quarter turn clockwise, around the same middle.
  const turned = follow(fingersAt(400, 200, 400, 400));
  isNear(turned.headingDeg, kView.headingDeg - 90 + 360, 1e-9);
  isNear(far(turned), 150, 1e-6);
  assert.ok(toViewPlane(turned, centre).every((c) => Math.abs(c) < 1e-9));
  // What was to the right of it turns to below it, as the fingers do.
  const { right: axis } = toCamera(kView);
  const beside = [0, 1, 2].map((a) => centre[a]! + axis[a]!) as unknown as Vec3;
  assert.ok(toViewPlane(turned, beside)[1] < 0 && toViewPlane(kView, beside)[0] > 0);
});

test('fingers that meet, or lie on the sky, do not throw the view away', () => {
  const before = fingersAt(300, 300, 500, 300);
  const met = fingersMoved(kView, before, fingersAt(400, 300, 400, 300), undefined, 100, kHeightPx);
  const left = Math.hypot(...[0, 1, 2].map((a) => met.position[a]! - kView.position[a]!));
  assert.ok(left <= 400.001, `${left}`);
  assert.ok(Object.values(met).flat().every(Number.isFinite));
  const apart = fingersMoved(kView, fingersAt(4, 4, 4, 4), before, undefined, 100, kHeightPx);
  assert.ok(Object.values(apart).flat().every(Number.isFinite));
});
