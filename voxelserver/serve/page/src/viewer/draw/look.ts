/** A picture's camera, and what a person chooses about it apart from its light. */
import type { Vec2, Vec3 } from '../../vec3.js';
import type { Layer } from './layers.js';

/** A perspective camera as the ray tracer's (raytracer/core/scene/camera.hpp), level-0 voxels. */
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

export type Look = {
  readonly shadows: boolean;
  readonly softSun: boolean;
  readonly occlusion: boolean;
  readonly textures: boolean;
  /** Holes between leaves. */
  readonly cutOuts: boolean;
  readonly bounces: number;
  /** Share of the true colours, [0, 1]; -1: true colours alone. */
  readonly colourMix: number;
  readonly exposureEv: number;
  readonly tone: 'photographic' | 'linear';
  /** What colours the picture instead of true colours. */
  readonly layer: Layer;
  /** Of the layer of heights: y of its lowest and highest colour, level-0 voxels. */
  readonly heightRange: Vec2;
  /** Cuts away what lies beyond a plane. */
  readonly section: Section | undefined;
  /** What cannot be seen from here is darkened; level-0 voxels. */
  readonly observer: Vec3 | undefined;
};

/** Points with dot(normal, p) > offset are cut away; level-0 voxels. */
export type Section = {
  /** Of unit length. */
  readonly normal: Vec3;
  readonly offset: number;
};

export const kDefaultLook: Look = {
  shadows: true,
  softSun: true,
  occlusion: true,
  textures: true,
  cutOuts: true,
  bounces: 6,
  colourMix: 0.85,
  exposureEv: 0,
  tone: 'photographic',
  layer: 'none',
  heightRange: [0, 1],
  section: undefined,
  observer: undefined,
};

const kFarthest = 2 ** 30; // level-0 voxels: where worlds end
const kMaxLengthError = 1e-3;

/** @throws Error for numbers that no picture can be drawn with */
export function checkLook({ heightRange, section, observer }: Look): void {
  const [low, high] = heightRange;
  if (!(isPlace(low) && isPlace(high) && low < high)) {
    refuse('heightRange', heightRange, 'two ascending numbers of voxels');
  }
  if (observer !== undefined && !observer.every(isPlace)) {
    refuse('observer', observer, 'three numbers of voxels');
  }
  if (section === undefined) return;
  if (!(Math.abs(Math.hypot(...section.normal) - 1) < kMaxLengthError)) {
    refuse('section.normal', section.normal, 'a vector of length 1');
  }
  // Three components can add up.
  if (!isPlace(section.offset / 2)) {
    refuse('section.offset', [section.offset], 'a number of voxels');
  }
}

const isPlace = (v: number): boolean => Math.abs(v) <= kFarthest;

function refuse(what: string, values: readonly number[], allowed: string): never {
  throw new Error(`set the look: ${what} = ${values.join(', ')}; allowed: ${allowed}`);
}
