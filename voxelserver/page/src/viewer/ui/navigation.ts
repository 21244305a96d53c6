/**
 * Where the camera is and how people move it: flying by keys, turning by dragging, orbiting around
 * a point, wheel, touch. Pure state and arithmetic; events come from controls.ts.
 */
import { cross, normalized, type Camera, type Vec3 } from '../draw/camera.js';

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
const kSteepestDeg = 89.9;
const kSteep = 1e-4;
const kFovDeg = [5, 120] as const;

/** Of unit length. */
export function forwardOf(view: Viewpoint): Vec3 {
  const flat = Math.cos(view.pitchDeg * kRad);
  return [
    Math.sin(view.headingDeg * kRad) * flat,
    Math.sin(view.pitchDeg * kRad),
    -Math.cos(view.headingDeg * kRad) * flat,
  ];
}

export function cameraOf(view: Viewpoint): Camera {
  const forward = forwardOf(view);
  const right = normalized(cross(forward, [0, 1, 0]));
  const up = cross(right, forward);
  const half = Math.tan((view.fovDeg * kRad) / 2);
  const scaled = (v: Vec3): Vec3 => [v[0] * half, v[1] * half, v[2] * half];
  return { position: view.position, forward, right: scaled(right), up: scaled(up) };
}

/** Turned to look from its position to a point. */
export function lookingAt(view: Viewpoint, target: Vec3): Viewpoint {
  const d = [0, 1, 2].map((a) => target[a]! - view.position[a]!) as unknown as Vec3;
  // Straight down or up, north is up in the picture, as in the ray tracer's.
  const isSteep = Math.hypot(d[0], d[2]) < kSteep * Math.hypot(...d);
  const heading = isSteep ? 0 : Math.atan2(d[0], -d[2]) / kRad;
  const pitch = Math.atan2(d[1], Math.hypot(d[0], d[2])) / kRad;
  return turnedTo(view, heading, pitch);
}

export function turned(view: Viewpoint, byHeadingDeg: number, byPitchDeg: number): Viewpoint {
  return turnedTo(view, view.headingDeg + byHeadingDeg, view.pitchDeg + byPitchDeg);
}

/** @param by right, up and forward along the line of sight, level-0 voxels */
export function moved(view: Viewpoint, by: Vec3): Viewpoint {
  const forward = forwardOf(view);
  const right: Vec3 = [Math.cos(view.headingDeg * kRad), 0, Math.sin(view.headingDeg * kRad)];
  const position = [0, 1, 2].map(
    (a) => view.position[a]! + right[a]! * by[0] + (a === 1 ? by[1] : 0) + forward[a]! * by[2],
  ) as unknown as Vec3;
  return { ...view, position };
}

/** Around a point, which stays where it is in the picture. */
export function orbited(
  view: Viewpoint,
  centre: Vec3,
  byHeadingDeg: number,
  byPitchDeg: number,
): Viewpoint {
  const next = turned(view, byHeadingDeg, byPitchDeg);
  const distance = Math.hypot(...[0, 1, 2].map((a) => centre[a]! - view.position[a]!));
  // The centre's place relative to the axes of the view stays the same.
  const [from, to] = [axesOf(view), axesOf(next)];
  const d = [0, 1, 2].map((a) => (centre[a]! - view.position[a]!) / distance) as unknown as Vec3;
  const inside = from.map((axis) => axis[0] * d[0] + axis[1] * d[1] + axis[2] * d[2]);
  const position = [0, 1, 2].map(
    (a) =>
      centre[a]! -
      distance * (to[0][a]! * inside[0]! + to[1][a]! * inside[1]! + to[2][a]! * inside[2]!),
  ) as unknown as Vec3;
  return { ...next, position };
}

export function zoomed(view: Viewpoint, factor: number): Viewpoint {
  return { ...view, fovDeg: clamp(view.fovDeg * factor, kFovDeg[0], kFovDeg[1]) };
}

function axesOf(view: Viewpoint): readonly [Vec3, Vec3, Vec3] {
  const forward = forwardOf(view);
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

function clamp(v: number, low: number, high: number): number {
  return Math.min(Math.max(v, low), high);
}
