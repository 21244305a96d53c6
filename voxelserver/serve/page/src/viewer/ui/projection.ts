/** Where points of the world lie in the picture: the inverse of the rays of a camera. */
import { type Vec2, along, dot, minus, type Vec3 } from '../../vec3.js';
import type { Camera } from '../draw/look.js';

/** Pixels from the upper left corner. */
export type Spot = Vec2;

const kNear = 0.05; // level-0 voxels in front of the eye, where segments are cut

/** Right, up and forward of the eye, in half heights of the picture and level-0 voxels. */
type Seen = Vec3;

/** @return undefined for points behind the camera */
export function projectPoint(camera: Camera, size: Vec2, point: Vec3): Spot | undefined {
  const seen = seenFrom(camera, minus(point, camera.position));
  return seen[2] < kNear ? undefined : onPicture(seen, size);
}

/** Of a direction, that is of a point at an infinite distance. */
export function spotOfDirection(camera: Camera, size: Vec2, direction: Vec3): Spot | undefined {
  const seen = seenFrom(camera, direction);
  return seen[2] < 1e-3 * Math.hypot(...direction) ? undefined : onPicture(seen, size);
}

/**
 * The part of a segment that is in front of the camera and inside the picture.
 * @return undefined when there is none
 */
export function projectSegment(
  camera: Camera,
  size: Vec2,
  from: Vec3,
  to: Vec3,
): readonly [Spot, Spot] | undefined {
  const a = seenFrom(camera, minus(from, camera.position));
  const b = seenFrom(camera, minus(to, camera.position));
  if (a[2] < kNear && b[2] < kNear) return undefined;
  const [near, far] = [cutAtNear(a, b), cutAtNear(b, a)];
  return clipped(onPicture(near, size), onPicture(far, size), size);
}

/**
 * The part of a segment inside a rectangle from [0, 0].
 * Ref: Liang & Barsky, "A New Concept and Method for Line Clipping", ACM TOG 1984.
 */
export function clipped(from: Spot, to: Spot, size: Vec2): readonly [Spot, Spot] | undefined {
  const d = [to[0] - from[0], to[1] - from[1]] as const;
  let [begin, end] = [0, 1];
  for (const axis of [0, 1] as const) {
    for (const [slope, room] of [
      [-d[axis], from[axis]],
      [d[axis], size[axis] - from[axis]],
    ] as const) {
      if (slope === 0 && room < 0) return undefined;
      if (slope < 0) begin = Math.max(begin, room / slope);
      if (slope > 0) end = Math.min(end, room / slope);
    }
  }
  if (begin > end) return undefined;
  const at = (t: number): Spot => [from[0] + t * d[0], from[1] + t * d[1]];
  return [at(begin), at(end)];
}

function cutAtNear(point: Seen, other: Seen): Seen {
  if (point[2] >= kNear) return point;
  const [x, y] = along(point, [minus(other, point), (kNear - point[2]) / (other[2] - point[2])]);
  return [x, y, kNear];
}

function seenFrom({ right, up, forward }: Camera, offset: Vec3): Seen {
  return [
    dot(offset, right) / dot(right, right),
    dot(offset, up) / dot(up, up),
    dot(offset, forward),
  ];
}

function onPicture(seen: Seen, [width, height]: Vec2): Spot {
  const half = height / 2;
  return [width / 2 + (seen[0] / seen[2]) * half, half - (seen[1] / seen[2]) * half];
}
