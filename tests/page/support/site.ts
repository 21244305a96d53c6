import type { Vec3 } from '../../../voxelserver/serve/page/src/vec3.js';

export const plus = (a: Vec3, b: Vec3, times = 1): Vec3 => [
  a[0] + b[0] * times,
  a[1] + b[1] * times,
  a[2] + b[2] * times,
];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** What the driver says of reading back a pixel. */
export const isNoise = (message: string): boolean => message.includes('GL Driver Message');
