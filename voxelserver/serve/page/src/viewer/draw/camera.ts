/** A perspective camera as the ray tracer's (raytracer/core/scene/camera.hpp), in level-0 voxels. */

export type Vec3 = readonly [number, number, number];

export type Camera = {
  readonly position: Vec3;
  /** Of unit length. */
  readonly forward: Vec3;
  /** At right angles to `forward` and to `up`, times the tangent of half the field of view. */
  readonly right: Vec3;
  readonly up: Vec3;
};

/** Angle covered by the pixel in the middle of a picture of this height. */
export function pixelRad(camera: Camera, heightPx: number): number {
  return (2 * Math.hypot(...camera.up)) / heightPx;
}

export function cross(a: Vec3, b: Vec3): Vec3 {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

export function normalized(v: Vec3): Vec3 {
  return scaled(v, 1 / Math.hypot(...v));
}

function scaled(v: Vec3, by: number): Vec3 {
  return [v[0] * by, v[1] * by, v[2] * by];
}
