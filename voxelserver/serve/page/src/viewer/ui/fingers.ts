/**
 * Two fingers on the picture, as maps have it. What lies between them follows: apart and together
 * bring it closer and farther, both along move it across, and turning one around the other turns
 * the view around it.
 */
import { along, clamp, minus, type Vec3 } from '../../vec3.js';
import { toCamera, computeForward, orbited, type Viewpoint } from './navigation.js';

export type FingerPlace = { readonly x: number; readonly y: number };
/** Places of two fingers, CSS pixels, y down. */
export type Fingers = readonly [first: FingerPlace, second: FingerPlace];

const kDeg = 180 / Math.PI;
/** Shares of the distance that one event may cover: fingers that meet must not lose the view. */
const kNearest = 0.8;
const kFarthest = -4;

/**
 * @param distance of what lies between the fingers, along the line of sight of the middle of the
 *   picture, level-0 voxels, above 0; of sky: how far the picture is taken to be
 * @param heightPx of the picture, CSS pixels
 */
export function fingersMoved(
  view: Viewpoint,
  before: Fingers,
  after: Fingers,
  centre: Vec3 | undefined,
  distance: number,
  heightPx: number,
): Viewpoint {
  const forward = computeForward(view);
  const at = centre ?? along(view.position, [forward, distance]);
  // What turns clockwise in the picture turns below a view that turns the other way.
  const next = orbited(view, at, -twistDeg(before, after), 0);
  const { right, up } = toCamera(next);
  const perPx = (2 * distance) / heightPx;
  const [from, to] = [findMiddle(before), findMiddle(after)];
  const toward = minus(at, next.position);
  const share = 1 - measureDistance(before) / Math.max(measureDistance(after), 1);
  const position = along(
    next.position,
    [right, (from[0] - to[0]) * perPx],
    [up, (to[1] - from[1]) * perPx],
    [toward, clamp(share, kFarthest, kNearest)],
  );
  return { ...next, position };
}

/** How far the line between two fingers has turned clockwise, degrees, (-180, 180]. */
export function twistDeg(before: Fingers, after: Fingers): number {
  const [a, b] = [between(before), between(after)];
  return Math.atan2(a.x * b.y - a.y * b.x, a.x * b.x + a.y * b.y) * kDeg;
}

export function findMiddle([first, second]: Fingers): readonly [x: number, y: number] {
  return [(first.x + second.x) / 2, (first.y + second.y) / 2];
}

function between([first, second]: Fingers): FingerPlace {
  return { x: second.x - first.x, y: second.y - first.y };
}

function measureDistance(fingers: Fingers): number {
  const { x, y } = between(fingers);
  return Math.hypot(x, y);
}
