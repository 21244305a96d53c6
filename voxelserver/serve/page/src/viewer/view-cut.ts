import type { Camera } from './draw/look.js';
import { along, dot, scaled, type Vec3 } from '../vec3.js';
import { LevelCut, type Bounds, type CutView } from './draw/level-cut.js';

/**
 * The cut of levels for a picture that is still coarse: as LevelCut within the view, and as coarse
 * as can be outside of it, where only shadows and reflections come from.
 */
export class ViewCut extends LevelCut {
  readonly #bounds: Bounds;
  readonly #eye: Vec3;
  /** Normals of the planes through the eye that bound the view, inwards. */
  readonly #planes: readonly Vec3[];

  /** @param aspect width of the picture / its height */
  constructor(bounds: Bounds, view: CutView, coarsest: number, camera: Camera, aspect: number) {
    super(bounds, view, coarsest);
    this.#bounds = bounds;
    this.#eye = camera.position;
    this.#planes = makePlanes(camera, aspect);
  }

  override isFarEnough(level: number, bx: number, bz: number): boolean {
    return super.isFarEnough(level, bx, bz) || !this.isInView(level, bx, bz);
  }

  /** Whether a column, from the bottom to the top of the bounds, may be in view. */
  isInView(level: number, bx: number, bz: number): boolean {
    const side = 64 * 2 ** level;
    const { min, max } = this.#bounds;
    const low = [bx * side, min[1], bz * side];
    const high = [(bx + 1) * side, max[1], (bz + 1) * side];
    return this.#planes.every((normal) => {
      // The corner that lies farthest on the inner side.
      const reach = (axis: 0 | 1 | 2): number =>
        normal[axis] * ((normal[axis] > 0 ? high : low)[axis]! - this.#eye[axis]);
      return reach(0) + reach(1) + reach(2) >= 0;
    });
  }
}

// A direction d is in the picture where |d.right / right^2| <= aspect d.forward, and likewise up.
function makePlanes({ forward, right, up }: Camera, aspect: number): Vec3[] {
  const plane = (side: Vec3, sign: number, reach: number): Vec3 =>
    along(scaled(forward, reach), [side, sign / dot(side, side)]);
  return [plane(right, 1, aspect), plane(right, -1, aspect), plane(up, 1, 1), plane(up, -1, 1)];
}
