import assert from 'node:assert/strict';

export function isNear(value: number, wanted: number, within = 1e-6): void {
  assert.ok(Math.abs(value - wanted) <= within, `${value} instead of ${wanted}`);
}
