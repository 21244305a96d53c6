/** What a pixel or a ray has met, from what the shader writes (draw/trace.glsl). */
import { readLook, type VoxelLook } from './data/box-arrays.js';
import { along, normalized, scaled, type Vec3 } from '../vec3.js';
import type { FirstHits } from './draw/hits.js';
import { kUnknownClass } from './draw/layers.js';
import type { Look, Camera } from './draw/look.js';

/** What a pixel of the picture shows, or what a ray has met. */
export type Pick = VoxelLook & {
  /** Of its level. */
  readonly voxel: Vec3;
  readonly level: number;
  /** -1: the cut face of a section, or the ray starts inside of a voxel. */
  readonly face: number;
  /** Level-0 voxels from the eye, or from the origin of the ray. */
  readonly distance: number;
  readonly point: Vec3;
  readonly isInSun: boolean;
  /** The survey's class; undefined: not known. */
  readonly lidarClass: number | undefined;
  /** From the observer; undefined without one. */
  readonly isVisible: boolean | undefined;
};

/**
 * @param i which of the hits
 * @return undefined where nothing was met
 */
export function makePick(
  hits: FirstHits,
  i: number,
  origin: Vec3,
  direction: Vec3,
  look: Look,
): Pick | undefined {
  const bits = hits.voxels[4 * i + 3]!;
  const has = (bit: number): boolean => ((bits >> bit) & 1) === 1;
  if (!has(13)) return undefined;
  const distance = new Float32Array(hits.details.buffer)[4 * i]!;
  const attribute = hits.details[4 * i + 1]!;
  const lidarClass = hits.details[4 * i + 2]!;
  return {
    voxel: [hits.voxels[4 * i]!, hits.voxels[4 * i + 1]!, hits.voxels[4 * i + 2]!],
    level: (bits >> 4) & 31,
    face: (bits & 7) === 7 ? -1 : bits & 7,
    distance,
    point: along(origin, [direction, distance]),
    ...readLook(attribute),
    isInSun: has(14),
    lidarClass: lidarClass === kUnknownClass ? undefined : lidarClass,
    isVisible: look.observer === undefined ? undefined : has(15),
  };
}

/** A camera whose picture of one pixel is this pixel. */
export function cameraAtPixel(
  camera: Camera,
  width: number,
  height: number,
  x: number,
  y: number,
): Camera {
  const across = (2 * (x + 0.5) - width) / height;
  const upward = (height - 2 * (y + 0.5)) / height;
  const { position, forward, right, up } = camera;
  const toPixel = normalized(along(forward, [right, across], [up, upward]));
  return {
    position,
    forward: toPixel,
    right: scaled(right, 1 / height),
    up: scaled(up, 1 / height),
  };
}
