/** Colours of a band's values: evenly spaced stops, dark to bright, which also differ in grey. */

const kStops = [[48, 18, 59], [65, 69, 171], [70, 117, 237], [57, 162, 252], [27, 207, 212], [36, 236, 166], [97, 252, 108], [164, 252, 60], [209, 232, 52], [243, 198, 58], [254, 155, 45], [243, 99, 21], [217, 56, 6]] as const;

export type ColourScale = { readonly min: number; readonly max: number };

/** The range of the values that are there; undefined: there is none. */
export function scaleOf(values: Float32Array, noData: number): ColourScale | undefined {
  let [min, max] = [Infinity, -Infinity];
  for (const value of values) {
    if (value === noData || Number.isNaN(value)) continue;
    min = Math.min(min, value);
    max = Math.max(max, value);
  }
  return min <= max ? { min, max } : undefined;
}

/** @return red, green, blue, 0 to 255 */
export function colourOf(value: number, { min, max }: ColourScale): [number, number, number] {
  const share = max > min ? Math.min(1, Math.max(0, (value - min) / (max - min))) : 1;
  const at = share * (kStops.length - 1);
  const from = kStops[Math.min(Math.floor(at), kStops.length - 2)]!;
  const to = kStops[Math.min(Math.floor(at), kStops.length - 2) + 1]!;
  const part = at - Math.min(Math.floor(at), kStops.length - 2);
  const mix = (i: 0 | 1 | 2): number => Math.round(from[i] + (to[i] - from[i]) * part);
  return [mix(0), mix(1), mix(2)];
}

/** Fills RGBA bytes: transparent where there is no value. */
export function paint(values: Float32Array, noData: number, scale: ColourScale, rgba: Uint8ClampedArray): void {
  values.forEach((value, i) => {
    if (value === noData || Number.isNaN(value)) return;
    rgba.set([...colourOf(value, scale), 255], 4 * i);
  });
}
