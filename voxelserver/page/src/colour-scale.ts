/** Colours of a band's values. */

/**
 * How values become colours: heights; shares and angles; sun and energy; directions, of which 0 and
 * 360 degrees have the same colour; hillshade.
 */
export type Ramp = 'heights' | 'much' | 'warm' | 'around' | 'grey';
type Stops = readonly (readonly [number, number, number])[];

/** Evenly spaced, those of the report (raytracer/analyse/report/band_style.cpp). */
const kStops: Readonly<Record<Ramp, Stops>> = {
  heights: [[62, 122, 74], [164, 184, 103], [222, 205, 140], [163, 120, 82], [245, 243, 240]],
  // Perceptually even. Ref: viridis and inferno, Smith and van der Walt, 2015 (public domain).
  much: [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]],
  warm: [[0, 0, 4], [87, 16, 110], [188, 55, 84], [249, 142, 9], [252, 255, 164]],
  around: [[226, 217, 226], [98, 118, 186], [47, 20, 54], [178, 84, 82], [226, 217, 226]],
  grey: [[0, 0, 0], [255, 255, 255]],
};

/** It has a length: max is above min. */
export type ColourScale = { readonly min: number; readonly max: number };
/** Ends of a scale; undefined: by the values. */
export type ScaleEnds = { readonly low?: number; readonly high?: number };

/** The range of the values that are there, with the ends that are given; undefined: there is no value. */
export function scaleOf(values: Float32Array, noData: number, { low, high }: ScaleEnds = {}): ColourScale | undefined {
  let [min, max] = [Infinity, -Infinity];
  for (const value of values) {
    if (value === noData || Number.isNaN(value)) continue;
    min = Math.min(min, value);
    max = Math.max(max, value);
  }
  return min <= max ? withLength(low ?? min, high ?? max) : undefined;
}

/** As in the report: where all values are alike, they have the colour of the least. */
function withLength(min: number, max: number): ColourScale {
  return { min, max: max > min ? max : min + Math.max(1, Math.abs(min) * 1e-3) };
}

/** @return red, green, blue, 0 to 255 */
export function colourOf(value: number, { min, max }: ColourScale, ramp: Ramp): [number, number, number] {
  const stops = kStops[ramp];
  const share = Math.min(1, Math.max(0, (value - min) / (max - min)));
  const at = share * (stops.length - 1);
  const below = Math.min(Math.floor(at), stops.length - 2);
  const [from, to] = [stops[below]!, stops[below + 1]!];
  const mix = (i: 0 | 1 | 2): number => Math.round(from[i] + (to[i] - from[i]) * (at - below));
  return [mix(0), mix(1), mix(2)];
}

/** Fills RGBA bytes: transparent where there is no value. */
export function paint(values: Float32Array, noData: number, scale: ColourScale, ramp: Ramp, rgba: Uint8ClampedArray): void {
  values.forEach((value, i) => {
    if (value === noData || Number.isNaN(value)) return;
    rgba.set([...colourOf(value, scale, ramp), 255], 4 * i);
  });
}
