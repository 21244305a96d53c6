/** A plane that cuts the picture open: upright by azimuth and position, or level by height. */
import { dot, minus, towards, type Vec3 } from '../../vec3.js';
import type { Section } from '../draw/renderer.js';
import { numbers, numbersWord } from './link.js';

export type SectionPlane = {
  readonly kind: 'off' | 'vertical' | 'horizontal';
  /** Of what is cut away, clockwise from north, [0, 360). */
  readonly azimuthDeg: number;
  /** Level-0 voxels from the pivot towards the azimuth. */
  readonly position: number;
  /** Level-0 voxels; what lies above is cut away. */
  readonly height: number;
  /** The other side is cut away. */
  readonly isFlipped: boolean;
};

const kFarthest = 2 ** 30;

/** @param pivot where an upright plane at position 0 passes through */
export function toSection(plane: SectionPlane, pivot: Vec3): Section | undefined {
  if (plane.kind === 'off') return undefined;
  const normal: Vec3 = plane.kind === 'vertical' ? towards(plane.azimuthDeg) : [0, 1, 0];
  const offset = plane.kind === 'vertical' ? dot(normal, pivot) + plane.position : plane.height;
  if (!plane.isFlipped) return { normal, offset };
  const opposite = (v: number): number => (v === 0 ? 0 : -v);
  return {
    normal: [opposite(normal[0]), opposite(normal[1]), opposite(normal[2])],
    offset: -offset,
  };
}

/** The same plane moved so that it passes through a point. */
export function through(plane: SectionPlane, pivot: Vec3, point: Vec3): SectionPlane {
  const position = dot(towards(plane.azimuthDeg), minus(point, pivot));
  return { ...plane, position, height: point[1] };
}

export function sectionWord(plane: SectionPlane): string {
  const flip = plane.isFlipped ? 1 : 0;
  return plane.kind === 'vertical'
    ? `v,${numbersWord([plane.azimuthDeg, plane.position, flip])}`
    : `h,${numbersWord([plane.height, flip])}`;
}

/** @return `otherwise` for what is no plane */
export function readSection(word: string | null, otherwise: SectionPlane): SectionPlane {
  const kind = word?.slice(0, 2);
  const rest = word?.slice(2) ?? null;
  const far = [-kFarthest, kFarthest] as const;
  const upright = kind === 'v,' ? numbers(rest, [[0, 360], far, [0, 1]]) : undefined;
  if (upright !== undefined) {
    const [azimuth, position, flip] = upright as [number, number, number];
    const azimuthDeg = azimuth % 360;
    return { ...otherwise, kind: 'vertical', azimuthDeg, position, isFlipped: flip === 1 };
  }
  const level = kind === 'h,' ? numbers(rest, [far, [0, 1]]) : undefined;
  if (level === undefined) return otherwise;
  return { ...otherwise, kind: 'horizontal', height: level[0]!, isFlipped: level[1] === 1 };
}
