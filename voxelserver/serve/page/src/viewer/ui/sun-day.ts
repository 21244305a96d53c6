/** The sun's way over a day: where it stands, when it rises and sets. */
import { sunPosition, type SunPosition } from '../draw/sun-position.js';
import type { MapPlace } from '../../replies.js';

export type SunAt = SunPosition & {
  /** UTC, milliseconds since 1970. */
  readonly timeMs: number;
};

export type SunDay = {
  /** Every ten minutes from one midnight of the place to the next, and at rise and set. */
  readonly path: readonly SunAt[];
  /** At full hours of UTC. */
  readonly hours: readonly SunAt[];
  readonly noon: SunAt;
  /** undefined when it does not. */
  readonly rise: SunAt | undefined;
  readonly set: SunAt | undefined;
};

const kDayMs = 86_400_000;
const kHourMs = 3_600_000;
const kStepMs = 600_000;
const kAccuracyMs = 500;
/** The sun's middle when its upper edge is on the horizon; positions hold refraction. */
const kEdgeDeg = -16 / 60;

/** @param timeMs any time of the day, UTC; the day is that of the place's mean sun */
export function sunDay(timeMs: number, place: MapPlace): SunDay {
  const at = (t: number): SunAt => ({ timeMs: t, ...sunPosition(t, place) });
  const shiftMs = (place.lonDeg / 360) * kDayMs;
  const midnight = Math.floor((timeMs + shiftMs) / kDayMs) * kDayMs - shiftMs;
  const path = Array.from({ length: kDayMs / kStepMs + 1 }, (_, i) => at(midnight + i * kStepMs));
  const firstHour = Math.ceil(midnight / kHourMs) * kHourMs;
  const altitude = (t: number): number => at(t).altitudeDeg - kEdgeDeg;
  const crossing = (isRise: boolean): SunAt | undefined => {
    const i = path.findIndex((next, k) => {
      const before = path[k - 1];
      if (before === undefined) return false;
      const [low, high] = isRise ? [before, next] : [next, before];
      return low.altitudeDeg < kEdgeDeg && high.altitudeDeg >= kEdgeDeg;
    });
    return i < 0 ? undefined : at(findZero(altitude, path[i - 1]!.timeMs, path[i]!.timeMs));
  };
  const [rise, set] = [crossing(true), crossing(false)];
  const edges = [rise, set].filter((edge) => edge !== undefined);
  return {
    path: [...path, ...edges].sort((a, b) => a.timeMs - b.timeMs),
    hours: Array.from({ length: 24 }, (_, i) => at(firstHour + i * kHourMs)),
    noon: at(highest(altitude, midnight + kDayMs / 4, midnight + (3 * kDayMs) / 4)),
    rise,
    set,
  };
}

/** Whether a part of the sun is above a level horizon. */
export function isUp({ altitudeDeg }: SunPosition): boolean {
  // Rise and set belong to the day, whatever the last digits of their search are.
  const kRoundingDeg = 1e-3;
  return altitudeDeg >= kEdgeDeg - kRoundingDeg;
}

function findZero(f: (t: number) => number, from: number, to: number): number {
  let [low, high] = [from, to];
  const isRising = f(low) < 0;
  while (high - low > kAccuracyMs) {
    const middle = (low + high) / 2;
    if (f(middle) < 0 === isRising) low = middle;
    else high = middle;
  }
  return (low + high) / 2;
}

// By thirds; the altitude has one top between six hours before and after noon.
function highest(f: (t: number) => number, from: number, to: number): number {
  let [low, high] = [from, to];
  while (high - low > kAccuracyMs) {
    const [a, b] = [low + (high - low) / 3, high - (high - low) / 3];
    if (f(a) < f(b)) low = a;
    else high = b;
  }
  return (low + high) / 2;
}
