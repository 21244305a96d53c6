/**
 * The link of a view: everything that a person sees, in the part of the address behind `#`. Numbers
 * have as many digits as it takes to see the same picture. Unknown words are ignored, numbers out
 * of range too: a link from elsewhere can ask for nothing but a view.
 */
import type { Viewpoint } from './navigation.js';

export type ViewState = {
  readonly view: Viewpoint;
  /** UTC, milliseconds since 1970; whole minutes. */
  readonly timeMs: number;
};

const kFarthest = 2 ** 30; // level-0 voxels
const kLatestMs = Date.UTC(2200, 0, 1);
const kMinuteMs = 60_000;

export function toLink(state: ViewState): string {
  const { view } = state;
  const place = view.position.map((v) => Number(v.toFixed(2))).join(',');
  const look = [view.headingDeg, view.pitchDeg, view.fovDeg].map((v) => Number(v.toFixed(2)));
  return `#at=${place}&look=${look.join(',')}&time=${Math.round(state.timeMs / kMinuteMs)}`;
}

/** @param link the part of an address from `#` on @param otherwise what it leaves open */
export function fromLink(link: string, otherwise: ViewState): ViewState {
  const words = new URLSearchParams(link.replace(/^#/, ''));
  const place = numbers(words.get('at'), [
    [-kFarthest, kFarthest],
    [-kFarthest, kFarthest],
    [-kFarthest, kFarthest],
  ]);
  const look = numbers(words.get('look'), [
    [0, 360],
    [-89.9, 89.9],
    [5, 120],
  ]);
  const time = numbers(words.get('time'), [[0, kLatestMs / kMinuteMs]]);
  const before = otherwise.view;
  return {
    view: {
      position: place === undefined ? before.position : [place[0]!, place[1]!, place[2]!],
      headingDeg: look?.[0] ?? before.headingDeg,
      pitchDeg: look?.[1] ?? before.pitchDeg,
      fovDeg: look?.[2] ?? before.fovDeg,
    },
    timeMs: time === undefined ? otherwise.timeMs : time[0]! * kMinuteMs,
  };
}

function numbers(
  text: string | null,
  ranges: readonly (readonly [number, number])[],
): number[] | undefined {
  if (text === null) return undefined;
  const values = text.split(',').map((word) => (word === '' ? NaN : Number(word)));
  if (values.length !== ranges.length) return undefined;
  if (values.some((v, i) => !(v >= ranges[i]![0] && v <= ranges[i]![1]))) return undefined;
  return values;
}
