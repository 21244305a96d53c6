/**
 * Which level of boxes represents which part of a world: the quadtree cut of the ray tracer
 * (raytracer/core/walk/level_cut.hpp), by the same numbers, so that both show the same voxels.
 */

import type { Vec2, Block, Vec3 } from '../../vec3.js';

/** Whole level-0 voxels. */
export type Bounds = Block;

export type CutView = {
  /** Level-0 voxels. */
  readonly eye: Vec3;
  /** A second eye, around which as much detail is needed: the observer of a line of sight. */
  readonly observer?: Vec3 | undefined;
  /** Angle covered by the pixel in the middle of the picture. */
  readonly pixelRad: number;
  /** Pixels that a voxel may cover; 0: the finest level everywhere. */
  readonly detail: number;
};

const kSideBits = 6; // log2 of the side of a box in voxels

export class LevelCut {
  /** The bounds at which rays enter: rounded outwards to voxels of the coarsest level. */
  readonly entry: Bounds;
  readonly coarsest: number;
  /** Of each eye: x, z, and the vertical distance to the world's range of heights. */
  readonly #eyes: readonly Vec3[];
  readonly #near2: readonly number[]; // square of the distance from which on a level is fine enough

  /** @param coarsest the coarsest level that the world has, 0 to 20 */
  constructor(bounds: Bounds, view: CutView, coarsest: number) {
    this.coarsest = view.detail > 0 ? coarsest : 0;
    const side = 2 ** this.coarsest;
    this.entry = {
      min: mapAxes((a) => Math.floor(bounds.min[a] / side) * side),
      max: mapAxes((a) => Math.ceil(bounds.max[a] / side) * side),
    };
    const eyes = view.observer === undefined ? [view.eye] : [view.eye, view.observer];
    this.#eyes = eyes.map(([x, y, z]) => [x, z, outside(y, bounds.min[1], bounds.max[1])]);
    this.#near2 = Array.from({ length: this.coarsest + 1 }, (_, level) => {
      const near = view.detail > 0 ? 2 ** level / (view.detail * view.pixelRad) : 0;
      return near * near;
    });
  }

  /**
   * Whether the column (bx, bz) of a level is far enough from all eyes to be shown at that level;
   * if
   * so, its halves are far enough for theirs.
   */
  isFarEnough(level: number, bx: number, bz: number): boolean {
    if (level <= 0) return true;
    if (level > this.coarsest) return false;
    return this.distance2(level, bx, bz) >= this.#near2[level]!;
  }

  /** Square of the distance from the nearest eye to a column of boxes, level-0 voxels. */
  distance2(level: number, bx: number, bz: number): number {
    const side = 2 ** (kSideBits + level);
    let nearest = Infinity;
    for (const [x, z, above] of this.#eyes) {
      const dx = outside(x, bx * side, (bx + 1) * side);
      const dz = outside(z, bz * side, (bz + 1) * side);
      nearest = Math.min(nearest, dx * dx + above * above + dz * dz);
    }
    return nearest;
  }

  /** The columns of the coarsest level that lie in the bounds: [first, past the last] of bx, bz. */
  roots(): { readonly x: Vec2; readonly z: Vec2 } {
    const side = 2 ** (kSideBits + this.coarsest);
    const range = (a: 0 | 2): [number, number] => [
      Math.floor(this.entry.min[a] / side),
      Math.ceil(this.entry.max[a] / side),
    ];
    return { x: range(0), z: range(2) };
  }

  /** Whether a column of a level reaches into the bounds. */
  touches(level: number, bx: number, bz: number): boolean {
    const side = 2 ** (kSideBits + level);
    const inside = (a: 0 | 2, b: number): boolean =>
      (b + 1) * side > this.entry.min[a] && b * side < this.entry.max[a];
    return inside(0, bx) && inside(2, bz);
  }
}

const mapAxes = (f: (axis: 0 | 1 | 2) => number): [number, number, number] => [f(0), f(1), f(2)];
const outside = (v: number, low: number, high: number): number => Math.max(low - v, v - high, 0);
