/** Lengths, heights and areas of points, in metres. */
import { distance, type Vec3 } from '../../vec3.js';

export type Measures = {
  /** Along the line. */
  readonly slopeM: number;
  readonly horizontalM: number;
  /** From the first point to the last one. */
  readonly heightM: number;
  /** Of the straight line from the first point to the last one, horizontally. */
  readonly spanM: number;
  /** Clockwise from north, [0, 360); undefined for points above each other. */
  readonly azimuthDeg: number | undefined;
  /** Of the polygon that the points close. */
  readonly areaM2: number;
  readonly perimeterM: number;
};

/** @param points level-0 voxels @param voxelM edge of a voxel */
export function measurePath(points: readonly Vec3[], voxelM: number): Measures {
  const [first, last] = [points[0], points.at(-1)];
  if (first === undefined || last === undefined) {
    return {
      slopeM: 0,
      horizontalM: 0,
      heightM: 0,
      spanM: 0,
      azimuthDeg: undefined,
      areaM2: 0,
      perimeterM: 0,
    };
  }
  const steps = points.slice(1).map((to, i) => [points[i]!, to] as const);
  const horizontalM = sum(steps.map(([a, b]) => flatDistance(a, b))) * voxelM;
  const spanM = flatDistance(first, last) * voxelM;
  const azimuth = (Math.atan2(last[0] - first[0], first[2] - last[2]) * 180) / Math.PI;
  return {
    slopeM: sum(steps.map(([a, b]) => distance(a, b))) * voxelM,
    horizontalM,
    heightM: (last[1] - first[1]) * voxelM,
    spanM,
    azimuthDeg: spanM > 0 ? (azimuth + 360) % 360 : undefined,
    areaM2: flatArea(points) * voxelM * voxelM,
    perimeterM: horizontalM + spanM,
  };
}

export const flatDistance = (a: Vec3, b: Vec3): number => Math.hypot(b[0] - a[0], b[2] - a[2]);

// Relative to the first point: coordinates of a country would leave few digits for the products.
function flatArea(points: readonly Vec3[]): number {
  const first = points[0]!;
  const at = points.map((p) => [p[0] - first[0], p[2] - first[2]] as const);
  const doubled = at.map(([x, z], i) => {
    const [nextX, nextZ] = at[(i + 1) % at.length]!;
    return x * nextZ - nextX * z;
  });
  return Math.abs(sum(doubled)) / 2;
}

const sum = (values: readonly number[]): number => values.reduce((all, value) => all + value, 0);
