/** Whether one point sees another. */
import { distance, minus, scaled, type Vec3 } from '../../vec3.js';
import type { CastRay, Pick } from '../stage.js';

export type Sight = {
  readonly distance: number;
  /** What is in the way, level-0 voxels; undefined: nothing. */
  readonly obstacle: Vec3 | undefined;
  /** Of the obstacle from the eye. */
  readonly obstacleDistance: number;
};

// A target lies on a voxel, which may be met before it: by a voxel's diagonal at most.
const kVoxelDiagonal = Math.sqrt(3);

/** @return undefined when both are the same point */
export function sightRay(eye: Vec3, target: Vec3): CastRay | undefined {
  const away = distance(eye, target);
  if (away === 0) return undefined;
  return { origin: eye, direction: scaled(minus(target, eye), 1 / away), maxT: away };
}

/** @param hit of the ray */
export function toSight(ray: CastRay, hit: Pick | undefined): Sight {
  const away = ray.maxT;
  const isTarget = hit === undefined || hit.distance > away - kVoxelDiagonal * 2 ** hit.level;
  return {
    distance: away,
    obstacle: isTarget ? undefined : hit.point,
    obstacleDistance: isTarget ? away : hit.distance,
  };
}
