/** What a pixel or a ray has met, from what the shader writes (draw/trace.glsl). */
import type { Camera, Vec3 } from './draw/camera.js';
import type { FirstHits } from './draw/hits.js';
import { kUnknownClass } from './draw/layers.js';
import type { Look } from './draw/look.js';

/** What a pixel of the picture shows, or what a ray has met. */
export type Pick = {
  /** Of its level. */
  readonly voxel: Vec3;
  readonly level: number;
  /** -1: the cut face of a section, or the ray starts inside of a voxel. */
  readonly face: number;
  /** Level-0 voxels from the eye, or from the origin of the ray. */
  readonly distance: number;
  readonly point: Vec3;
  readonly material: number;
  readonly colour: readonly [number, number, number] | undefined;
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
  const attribute = hits.details[4 * i + 1]! >>> 0;
  const lidarClass = hits.details[4 * i + 2]!;
  return {
    voxel: [hits.voxels[4 * i]!, hits.voxels[4 * i + 1]!, hits.voxels[4 * i + 2]!],
    level: (bits >> 4) & 31,
    face: (bits & 7) === 7 ? -1 : bits & 7,
    distance,
    point: [0, 1, 2].map((a) => origin[a]! + direction[a]! * distance) as unknown as Vec3,
    material: (attribute >> 24) & 63,
    colour:
      attribute >>> 31 === 1
        ? [attribute & 255, (attribute >> 8) & 255, (attribute >> 16) & 255]
        : undefined,
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
  const d = [0, 1, 2].map(
    (a) => camera.forward[a]! + camera.right[a]! * across + camera.up[a]! * upward,
  );
  const length = Math.hypot(...d);
  const forward = d.map((v) => v / length) as unknown as Vec3;
  const shrink = (v: Vec3): Vec3 => v.map((c) => c / height) as unknown as Vec3;
  return { position: camera.position, forward, right: shrink(camera.right), up: shrink(camera.up) };
}
