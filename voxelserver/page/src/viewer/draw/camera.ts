/** A perspective camera as the ray tracer's (raytracer/scene/camera.hpp), in level-0 voxels. */

export type Vec3 = readonly [number, number, number];

export type Camera = {
  readonly position: Vec3;
  /** Of unit length. */
  readonly forward: Vec3;
  /** At right angles to `forward` and to each other, times the tangent of half the field of view. */
  readonly right: Vec3;
  readonly up: Vec3;
};

const kRad = Math.PI / 180;

/** @param fovDeg vertical field of view */
export function cameraTowards(position: Vec3, target: Vec3, fovDeg: number): Camera {
  const forward = normalized([
    target[0] - position[0],
    target[1] - position[1],
    target[2] - position[2],
  ]);
  // Straight down or up: north is up in the picture.
  const pole: Vec3 = Math.abs(forward[1]) > 0.99999 ? [0, 0, -1] : [0, 1, 0];
  const right = normalized(cross(forward, pole));
  const up = cross(right, forward);
  const half = Math.tan((fovDeg * kRad) / 2);
  return { position, forward, right: scaled(right, half), up: scaled(up, half) };
}

/** Angle covered by the pixel in the middle of a picture of this height. */
export function pixelRad(camera: Camera, heightPx: number): number {
  return (2 * Math.hypot(...camera.up)) / heightPx;
}

/** The direction through picture coordinates in pixels, y down; of unit length. */
export function directionAt(camera: Camera, widthPx: number, heightPx: number, x: number, y: number): Vec3 {
  const across = (2 * x - widthPx) / heightPx;
  const upward = (heightPx - 2 * y) / heightPx;
  return normalized([
    camera.forward[0] + camera.right[0] * across + camera.up[0] * upward,
    camera.forward[1] + camera.right[1] * across + camera.up[1] * upward,
    camera.forward[2] + camera.right[2] * across + camera.up[2] * upward,
  ]);
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
