/** Lengths, heights and areas of points, in metres. */
import { distance, type Vec3 } from '../../vec3.js';

export type Measures = Readonly<ReturnType<typeof computeMeasures>>;

/** @param points level-0 voxels @param voxelM edge of a voxel */
export const measurePath = (points: readonly Vec3[], voxelM: number): Measures =>
  computeMeasures(points, voxelM);

function computeMeasures(points: readonly Vec3[], voxelM: number) {
  const [first = kOrigin, last = kOrigin] = [points[0], points.at(-1)];
  const steps = points.slice(1).map((to, i) => [points[i]!, to] as const);
  const horizontalM = sum(steps.map(([a, b]) => flatDistance(a, b))) * voxelM;
  const spanM = flatDistance(first, last) * voxelM;
  const azimuth = (Math.atan2(last[0] - first[0], first[2] - last[2]) * 180) / Math.PI;
  return {
    /** Along the line. */
    slopeM: sum(steps.map(([a, b]) => distance(a, b))) * voxelM,
    horizontalM,
    /** From the first point to the last one. */
    heightM: (last[1] - first[1]) * voxelM,
    /** Of the straight line from the first point to the last one, horizontally. */
    spanM,
    /** Clockwise from north, [0, 360); undefined for points above each other. */
    azimuthDeg: spanM > 0 ? (azimuth + 360) % 360 : undefined,
    /** Of the polygon that the points close. */
    areaM2: flatArea(points) * voxelM * voxelM,
    perimeterM: horizontalM + spanM,
  };
}

const kOrigin: Vec3 = [0, 0, 0];

export const flatDistance = (a: Vec3, b: Vec3): number => Math.hypot(b[0] - a[0], b[2] - a[2]);

// Relative to the first point: coordinates of a country would leave few digits for the products.
function flatArea(points: readonly Vec3[]): number {
  const [first = kOrigin] = points;
  const at = points.map((p) => [p[0] - first[0], p[2] - first[2]] as const);
  const doubled = at.map(([x, z], i) => {
    const [nextX, nextZ] = at[(i + 1) % at.length]!;
    return x * nextZ - nextX * z;
  });
  return Math.abs(sum(doubled)) / 2;
}

const sum = (values: readonly number[]): number => values.reduce((all, value) => all + value, 0);
