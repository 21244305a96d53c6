/**
 * The link of a view: everything that a person sees, in the part of the address behind `#`. Numbers
 * have as many digits as it takes to see the same picture. Unknown words are ignored, numbers out
 * of range too: a link from elsewhere can ask for nothing but a view. Tools and switches have words
 * of their own, which are there only where they differ from what the page begins with.
 */
import type { Vec2, Vec3 } from '../../vec3.js';
import type { Viewpoint } from './navigation.js';

export type ViewState = {
  readonly view: Viewpoint;
  /** UTC, milliseconds since 1970; whole minutes. */
  readonly timeMs: number;
};

const kFarthest = 2 ** 30; // level-0 voxels
const kLatestMs = Date.UTC(2200, 0, 1);
const kMinuteMs = 60_000;

/** Of tools and switches: a name, and a value of letters, digits and `,._-`, if it is there. */
export type Words = Readonly<Record<string, string | undefined>>;

export const kMaxPoints = 64;

/** Of a view alone. */
export const viewWords = ({ position, headingDeg, pitchDeg, fovDeg }: Viewpoint): string =>
  `at=${numbersWord(position)}&look=${numbersWord([headingDeg, pitchDeg, fovDeg])}`;

export function toLink({ view, timeMs }: ViewState, others: Words = {}): string {
  const own = `#${viewWords(view)}&time=${Math.round(timeMs / kMinuteMs)}`;
  const known = Object.entries(others).filter(([, value]) => value !== undefined);
  return [own, ...known.map(([name, value]) => `${name}=${value}`)].join('&');
}

/** What a link says about tools and switches. */
export function parseWords(link: string): URLSearchParams {
  const words = new URLSearchParams(link.replace(/^#/, ''));
  for (const own of ['at', 'look', 'time']) words.delete(own);
  return words;
}

export function pointsWord(points: readonly Vec3[]): string {
  return points.map((point) => numbersWord(point)).join('_');
}

/** @return no points when there are more than 64, or one of them is none */
export function readPoints(word: string | null): readonly Vec3[] {
  if (word === null) return [];
  const parts = word.split('_');
  if (parts.length > kMaxPoints) return [];
  const points = parts.map(readPoint);
  return points.every((point) => point !== undefined) ? points : [];
}

/** Level-0 voxels. */
export function readPoint(word: string | null): Vec3 | undefined {
  const far = [-kFarthest, kFarthest] as const;
  const values = numbers(word, [far, far, far]);
  return values === undefined ? undefined : [values[0]!, values[1]!, values[2]!];
}

export function numbersWord(values: readonly number[]): string {
  return values.map((v) => Number(v.toFixed(2))).join(',');
}

/** @param link the part of an address from `#` on @param otherwise what it leaves open */
export function fromLink(link: string, otherwise: ViewState): ViewState {
  const words = new URLSearchParams(link.replace(/^#/, ''));
  const place = readPoint(words.get('at'));
  const look = numbers(words.get('look'), [
    [0, 360],
    [-89.9, 89.9],
    [5, 120],
  ]);
  const time = numbers(words.get('time'), [[0, kLatestMs / kMinuteMs]]);
  const before = otherwise.view;
  return {
    view: {
      position: place ?? before.position,
      headingDeg: look?.[0] ?? before.headingDeg,
      pitchDeg: look?.[1] ?? before.pitchDeg,
      fovDeg: look?.[2] ?? before.fovDeg,
    },
    timeMs: time === undefined ? otherwise.timeMs : time[0]! * kMinuteMs,
  };
}

/** @return undefined unless there are as many numbers as ranges, each inside its own */
export function numbers(text: string | null, ranges: readonly Vec2[]): number[] | undefined {
  if (text === null) return undefined;
  const values = text.split(',').map((word) => (word === '' ? NaN : Number(word)));
  if (values.length !== ranges.length) return undefined;
  if (values.some((v, i) => !(v >= ranges[i]![0] && v <= ranges[i]![1]))) return undefined;
  return values;
}
