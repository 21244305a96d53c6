/** Vectors of three numbers, most of them places and directions: x east, y up, z south. */
export type Vec3 = readonly [number, number, number];
/** A size, a place of a picture, or the ends of a range. */
export type Vec2 = readonly [number, number];

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const minus = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scaled = (v: Vec3, by: number): Vec3 => [v[0] * by, v[1] * by, v[2] * by];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const normalized = (v: Vec3): Vec3 => scaled(v, 1 / Math.hypot(...v));
export const distance = (a: Vec3, b: Vec3): number => Math.hypot(...minus(b, a));
export const halfway = (a: Vec3, b: Vec3): Vec3 => scaled(add(a, b), 0.5);

export function cross(a: Vec3, b: Vec3): Vec3 {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

/** A place so many times each direction away from another one. */
export function along(from: Vec3, ...steps: readonly (readonly [by: Vec3, times: number])[]): Vec3 {
  return steps.reduce((at, [by, times]) => add(at, scaled(by, times)), from);
}

/** Of unit length. @param azimuthDeg clockwise from north @param altitudeDeg above the horizon */
export function towards(azimuthDeg: number, altitudeDeg = 0): Vec3 {
  const [azimuth, altitude] = [(azimuthDeg * Math.PI) / 180, (altitudeDeg * Math.PI) / 180];
  const flat = Math.cos(altitude);
  return [Math.sin(azimuth) * flat, Math.sin(altitude), -Math.cos(azimuth) * flat];
}

/** Half-open: min <= place < max. */
export type Block = { readonly min: Vec3; readonly max: Vec3 };

/** @return `v`, or the end of the range that it lies beyond */
export const clamp = (v: number, low: number, high: number): number =>
  Math.min(Math.max(v, low), high);
