import { clamp, type Vec3 } from './vec3.js';

/** Colours of a band's values. */

/**
 * How values become colours: heights; shares and angles; sun and energy; directions, of which 0 and
 * 360 degrees have the same colour; hillshade.
 */
export type Ramp = 'heights' | 'much' | 'warm' | 'around' | 'grey';
type Stops = readonly Vec3[];

/** Evenly spaced, those of the report (raytracer/analyse/report/band_style.cpp). */
const kStops: Readonly<Record<Ramp, Stops>> = {
  heights: toStops('3e7a4a a4b867 decd8c a37852 f5f3f0'),
  // Perceptually even. Ref: viridis and inferno, Smith and van der Walt, 2015 (public domain).
  much: toStops('440154 3b528b 21918c 5ec962 fde725'),
  warm: toStops('000004 57106e bc3754 f98e09 fcffa4'),
  around: toStops('e2d9e2 6276ba 2f1436 b25452 e2d9e2'),
  grey: toStops('000000 ffffff'),
};

/** @return undefined for a name that is none, such as that of colours for classes */
export const toRamp = (name = ''): Ramp | undefined =>
  Object.hasOwn(kStops, name) ? (name as Ramp) : undefined;

/** @param colours red, green, blue as six hexadecimal digits each */
function toStops(colours: string): Stops {
  return colours.split(' ').map((colour): Vec3 => {
    const part = (i: number): number => parseInt(colour.slice(2 * i, 2 * i + 2), 16);
    return [part(0), part(1), part(2)];
  });
}

/** It has a length: max is above min. */
export type ColourScale = { readonly min: number; readonly max: number };
/** Ends of a scale; undefined: by the values. */
export type ScaleEnds = { readonly low?: number; readonly high?: number };

/** Of the values, on each side: as in the report, they lie beyond an end that the values give. */
const kOutermost = 0.01;

/** Of a histogram, which unlike sorting takes no notable time for millions of values. */
const kBins = 4096;

/**
 * The ends that are given, else those between which nearly all values lie: one mast must not give
 * all other cells one colour.
 * @return undefined: there is no value
 */
export function chooseScale(
  values: Float32Array,
  noData: number,
  { low, high }: ScaleEnds = {},
): ColourScale | undefined {
  const isThere = (value: number): boolean => value !== noData && Number.isFinite(value);
  let [min, max, count] = [Infinity, -Infinity, 0];
  for (const value of values) {
    if (!isThere(value)) continue;
    min = Math.min(min, value);
    max = Math.max(max, value);
    ++count;
  }
  if (count === 0) return undefined;
  if (low !== undefined && high !== undefined) return withLength(low, high);
  const counts = new Uint32Array(kBins);
  const largest = new Float32Array(kBins).fill(-Infinity);
  const binsPerUnit = max > min ? kBins / (max - min) : 0;
  for (const value of values) {
    if (!isThere(value)) continue;
    const bin = Math.min(kBins - 1, Math.floor((value - min) * binsPerUnit));
    ++counts[bin]!;
    largest[bin] = Math.max(largest[bin]!, value);
  }
  const quantile = (share: number): number => {
    let below = 0;
    const bin = counts.findIndex((inBin) => (below += inBin) >= share * count);
    return largest[bin]!;
  };
  return withLength(low ?? quantile(kOutermost), high ?? quantile(1 - kOutermost));
}

/** As in the report: where all values are alike, they have the colour of the least. */
function withLength(min: number, max: number): ColourScale {
  return { min, max: max > min ? max : min + Math.max(1, Math.abs(min) * 1e-3) };
}

/** @return red, green, blue, 0 to 255 */
export function toColour(value: number, { min, max }: ColourScale, ramp: Ramp): Vec3 {
  const stops = kStops[ramp];
  const share = clamp((value - min) / (max - min), 0, 1);
  const at = share * (stops.length - 1);
  const below = Math.min(Math.floor(at), stops.length - 2);
  const [from, to] = [stops[below]!, stops[below + 1]!];
  const mix = (i: 0 | 1 | 2): number => Math.round(from[i] + (to[i] - from[i]) * (at - below));
  return [mix(0), mix(1), mix(2)];
}

/** A background that is a legend. @param isEnd of the colour of the highest value alone */
export function toGradient(ramp: Ramp, isEnd: boolean): string {
  const colours = kStops[ramp].map((colour) => `rgb(${colour.join(' ')})`);
  const shown = isEnd ? [colours.at(-1), colours.at(-1)] : colours;
  return `linear-gradient(to right, ${shown.join()})`;
}

/** Fills RGBA bytes: transparent where there is no value. */
export function paint(
  values: Float32Array,
  noData: number,
  scale: ColourScale,
  ramp: Ramp,
  rgba: Uint8ClampedArray,
): void {
  values.forEach((value, i) => {
    if (value === noData || Number.isNaN(value)) return;
    rgba.set([...toColour(value, scale, ramp), 255], 4 * i);
  });
}
