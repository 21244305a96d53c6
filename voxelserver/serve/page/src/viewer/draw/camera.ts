/**
 * A perspective camera as the ray tracer's (raytracer/core/scene/camera.hpp), in level-0 voxels.
 */

import type { Vec3 } from '../../vec3.js';

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
