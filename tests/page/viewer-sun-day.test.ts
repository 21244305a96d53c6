import assert from 'node:assert/strict';
import { test } from 'node:test';
import { type Vec3, towards } from '../../voxelserver/serve/page/src/vec3.js';
import type { MapPlace } from '../../voxelserver/serve/page/src/replies.js';
import { sunPosition } from '../../voxelserver/serve/page/src/viewer/draw/sun-position.js';
import { isUp, sunDay } from '../../voxelserver/serve/page/src/viewer/ui/sun-day.js';
import { isNear } from './support/near.js';

const at = (latDeg: number, lonDeg: number): MapPlace => ({ latDeg, lonDeg, convergenceDeg: 0 });

test('the sun rises and sets when almanacs say so', () => {
  // Ljubljana, midsummer 2026: rise 3:11 to 3:12, set 18:57 to 18:58 UTC (flat horizon).
  const day = sunDay(Date.UTC(2026, 5, 21, 15, 30), at(46.05, 14.51));
  const minutes = (ms: number): number => (ms - Date.UTC(2026, 5, 21)) / 60_000;
  isNear(minutes(day.rise!.timeMs), 3 * 60 + 11.5, 1.5);
  isNear(minutes(day.set!.timeMs), 18 * 60 + 57, 1.5);
  isNear(minutes(day.noon.timeMs), 11 * 60 + 4, 1.5);
  isNear(day.noon.azimuthDeg, 180, 0.5);
  isNear(day.noon.altitudeDeg, 90 - 46.05 + 23.44, 0.05);
  const times = day.path.map((one) => one.timeMs);
  assert.ok(times.includes(day.rise!.timeMs) && times.includes(day.set!.timeMs));
  assert.deepEqual(
    times,
    [...times].sort((a, b) => a - b),
  );
  assert.ok(isUp(day.rise!) && isUp(day.set!) && !isUp(day.path[0]!));
  assert.ok(day.path.every((one) => one.altitudeDeg <= day.noon.altitudeDeg + 1e-3));
  assert.equal(day.hours.length, 24);
  assert.ok(day.hours.every((one) => one.timeMs % 3_600_000 === 0));
});

test('a day is that of the place, wherever it lies', () => {
  for (const lonDeg of [-180, -120, 0, 75, 179]) {
    const timeMs = Date.UTC(2026, 2, 20, 5);
    const { path, rise, noon, set } = sunDay(timeMs, at(-33, lonDeg));
    assert.ok(path[0]!.timeMs <= timeMs && timeMs <= path.at(-1)!.timeMs, `${lonDeg}`);
    assert.ok(rise!.timeMs < noon.timeMs && noon.timeMs < set!.timeMs, `${lonDeg}`);
    isNear(sunPosition(rise!.timeMs, at(-33, lonDeg)).altitudeDeg, -16 / 60, 1e-2);
  }
});

test('where the sun does not rise or set, there is no such time', () => {
  const summer = sunDay(Date.UTC(2026, 5, 21, 12), at(78, 15));
  assert.deepEqual([summer.rise, summer.set], [undefined, undefined]);
  assert.ok(summer.noon.altitudeDeg > 0);
  const winter = sunDay(Date.UTC(2026, 11, 21, 12), at(78, 15));
  assert.deepEqual([winter.rise, winter.set], [undefined, undefined]);
  assert.ok(winter.noon.altitudeDeg < 0);
});

test('directions to the sun are those of the light', () => {
  const near = (v: Vec3, wanted: Vec3): void => v.forEach((c, a) => isNear(c, wanted[a]!, 1e-9));
  near(towards(0, 0), [0, 0, -1]);
  near(towards(90, 0), [1, 0, 0]);
  near(towards(0, 90), [0, 1, 0]);
});
