/**
 * Where the camera is and how people move it: flying by keys, turning by dragging, orbiting around
 * a point, wheel, touch. Pure state and arithmetic; events come from controls.ts.
 */
import {
  along,
  clamp,
  cross,
  dot,
  minus,
  normalized,
  scaled,
  towards,
  type Block,
  type Vec3,
} from '../../vec3.js';
import type { Camera } from '../draw/look.js';
import type { FoundPlace } from '../../coordinates.js';
import type { WorldProjection } from '../../world-projection.js';

export type Viewpoint = {
  /** Level-0 voxels: x east, y up, z south. */
  readonly position: Vec3;
  /** Clockwise from north, degrees, [0, 360). */
  readonly headingDeg: number;
  /** Above the horizon, degrees, [-89.9, 89.9]. */
  readonly pitchDeg: number;
  /** Vertical field of view, degrees, [5, 120]. */
  readonly fovDeg: number;
};

const kRad = Math.PI / 180;
const kNearest = 60; // level-0 voxels above and south of a place that is looked at
const kSteepestDeg = 89.9;
const kSteep = 1e-4;
const kFovDeg = [5, 120] as const;
const kFrameMargin = 0.04; // of what a block is fitted into, on each side

/** Of unit length. */
export const computeForward = ({ headingDeg, pitchDeg }: Viewpoint): Vec3 =>
  towards(headingDeg, pitchDeg);

export function toCamera(view: Viewpoint): Camera {
  const [right, up, forward] = computeAxes(view);
  const half = Math.tan((view.fovDeg * kRad) / 2);
  return { position: view.position, forward, right: scaled(right, half), up: scaled(up, half) };
}

export function isSameView(a: Viewpoint, b: Viewpoint): boolean {
  return (
    a.position.every((v, i) => v === b.position[i]) &&
    a.headingDeg === b.headingDeg &&
    a.pitchDeg === b.pitchDeg &&
    a.fovDeg === b.fovDeg
  );
}

/** Turned to look from its position to a point. */
export function lookingAt(view: Viewpoint, target: Vec3): Viewpoint {
  const d = minus(target, view.position);
  // Straight down or up, north is up in the picture, as in the ray tracer's.
  const isSteep = Math.hypot(d[0], d[2]) < kSteep * Math.hypot(...d);
  const heading = isSteep ? 0 : Math.atan2(d[0], -d[2]) / kRad;
  const pitch = Math.atan2(d[1], Math.hypot(d[0], d[2])) / kRad;
  return turnedTo(view, heading, pitch);
}

/** From above and from the south, whatever height the place has. */
export function toView(
  { easting, northing }: FoundPlace,
  projection: WorldProjection,
  before: Viewpoint,
): Viewpoint {
  const [x, z] = projection.toVoxel(easting, northing);
  const { min, max } = projection.world;
  const middle = (min[1] + max[1]) / 2;
  const away = Math.max(kNearest, max[1] - min[1]);
  return lookingAt({ ...before, position: [x, middle + away, z + away] }, [x, middle, z]);
}

export function turned(view: Viewpoint, byHeadingDeg: number, byPitchDeg: number): Viewpoint {
  return turnedTo(view, view.headingDeg + byHeadingDeg, view.pitchDeg + byPitchDeg);
}

/** @param by right, up and forward along the line of sight, level-0 voxels */
export function moved(view: Viewpoint, by: Vec3): Viewpoint {
  const [right, up, forward] = [
    towards(view.headingDeg + 90),
    [0, 1, 0],
    computeForward(view),
  ] as const;
  const [across, upward, ahead] = by;
  return {
    ...view,
    position: along(view.position, [right, across], [up, upward], [forward, ahead]),
  };
}

/** Around a point, which stays where it is in the picture. */
export function orbited(
  view: Viewpoint,
  centre: Vec3,
  byHeadingDeg: number,
  byPitchDeg: number,
): Viewpoint {
  const next = turned(view, byHeadingDeg, byPitchDeg);
  // The centre's place relative to the axes of the view stays the same.
  const [right, up, forward] = computeAxes(next);
  const [x, y, z] = computeAxes(view).map((axis) => dot(axis, minus(view.position, centre)));
  return { ...next, position: along(centre, [right, x!], [up, y!], [forward, z!]) };
}

/**
 * The same direction and field of view, from where a block just fits into the picture.
 * @param aspect width of the picture by its height
 * @param covered share of the picture on the left that does not count
 */
export function fitted(view: Viewpoint, frame: Block, aspect: number, covered: number): Viewpoint {
  const [right, up, forward] = computeAxes(view);
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i): Vec3 => {
    const side = (a: 0 | 1 | 2): number => (((i >> a) & 1) === 0 ? frame.min : frame.max)[a];
    return [side(0), side(1), side(2)];
  });
  const half = Math.tan((view.fovDeg * kRad) / 2);
  const [wide, high] = [half * aspect, half];
  const margin = 2 * kFrameMargin;
  const inset = margin * (1 - covered);
  const left = 2 * covered - 1 + inset;
  const across = rangeThatFits(corners, right, forward, left * wide, (1 - inset) * wide);
  const upward = rangeThatFits(corners, up, forward, (margin - 1) * high, (1 - margin) * high);
  const depth = Math.min(across.farthest, upward.farthest);
  const [x, y] = [across.middleAt(depth), upward.middleAt(depth)];
  return { ...view, position: along(scaled(right, x), [up, y], [forward, depth]) };
}

// Where the eye may be, for one axis of the picture: a corner at (c, z), by that axis and by depth,
// lies between two slopes as seen from (e, d) if low * (z - d) <= c - e <= high * (z - d).
function rangeThatFits(
  corners: readonly Vec3[],
  axis: Vec3,
  forward: Vec3,
  low: number,
  high: number,
): { readonly farthest: number; readonly middleAt: (depth: number) => number } {
  const least = Math.max(...corners.map((c) => dot(axis, c) - high * dot(forward, c)));
  const most = Math.min(...corners.map((c) => dot(axis, c) - low * dot(forward, c)));
  return {
    farthest: (most - least) / (high - low),
    middleAt: (depth) => (least + high * depth + most + low * depth) / 2,
  };
}

export function zoomed(view: Viewpoint, factor: number): Viewpoint {
  return { ...view, fovDeg: clamp(view.fovDeg * factor, kFovDeg[0], kFovDeg[1]) };
}

function computeAxes(view: Viewpoint): readonly [Vec3, Vec3, Vec3] {
  const forward = computeForward(view);
  const right = normalized(cross(forward, [0, 1, 0]));
  return [right, cross(right, forward), forward];
}

function turnedTo(view: Viewpoint, headingDeg: number, pitchDeg: number): Viewpoint {
  return {
    ...view,
    headingDeg: headingDeg - 360 * Math.floor(headingDeg / 360),
    pitchDeg: clamp(pitchDeg, -kSteepestDeg, kSteepestDeg),
  };
}
