import type { ColourScale, Ramp, ScaleEnds } from './colour-scale.js';

/**
 * How the bands of analyses are drawn: colours and fixed ends are those of the report
 * (raytracer/analyse/evaluators/analysis.cpp), which also rounds the ends that the values give.
 */

export type BandStyle = ScaleEnds & {
  readonly title: string;
  readonly ramp: Ramp;
  /** Values are hours of a clock. */
  readonly isClock?: true;
  /** Values are 0 or 1: what these mean. Zero gets no colour. */
  readonly words?: readonly [string, string];
};

const kStyles: Readonly<Record<string, BandStyle>> = {
  dsm: { title: 'Height of the surface', ramp: 'heights' },
  dtm: { title: 'Height of the ground', ramp: 'heights' },
  ndsm: { title: 'Height above the ground', ramp: 'much', low: 0 },
  slope: { title: 'Slope', ramp: 'much', low: 0 },
  aspect: { title: 'Aspect, clockwise from north', ramp: 'around', low: 0, high: 360 },
  hillshade: { title: 'Hillshade', ramp: 'grey', low: 0, high: 255 },
  svf: { title: 'Sky-view factor', ramp: 'much', low: 0, high: 1 },
  sky_view_solid: { title: 'Share of the sky', ramp: 'much', low: 0, high: 1 },
  openness: { title: 'Openness', ramp: 'much', low: 0, high: 90 },
  sun_hours: { title: 'Hours of direct sun', ramp: 'warm', low: 0 },
  first_sun: { title: 'First sun, clock time', ramp: 'much', isClock: true },
  last_sun: { title: 'Last sun, clock time', ramp: 'much', isClock: true },
  sun_hours_per_day: { title: 'Hours of direct sun a day', ramp: 'warm', low: 0 },
  sun_share: { title: 'Share of daylight in the sun', ramp: 'warm', low: 0, high: 1 },
  kwh_m2: { title: 'Energy of sun and sky', ramp: 'warm', low: 0 },
  beam: { title: 'Energy directly from the sun', ramp: 'warm', low: 0 },
  diffuse: { title: 'Energy from the sky', ramp: 'warm', low: 0 },
  reflected: { title: 'Energy from what is around', ramp: 'warm', low: 0 },
  seen: {
    title: 'Seen from the place',
    ramp: 'much',
    low: 0,
    high: 1,
    words: ['not seen', 'seen'],
  },
  clearance: { title: 'Free height above the ground', ramp: 'much', low: 0 },
  distance_m: { title: 'Distance to the place', ramp: 'much', low: 0 },
  hole: {
    title: 'Data that could not be read',
    ramp: 'much',
    low: 0,
    high: 1,
    words: ['read', 'could not be read'],
  },
};
/** Bands whose values are numbers of something: no colours between them mean anything. */
const kHiddenBands = new Set(['class', 'material', 'red', 'green', 'blue', 'dtm_source']);

/** @return undefined for a band that is not drawn */
export function chooseStyle(band: string): BandStyle | undefined {
  if (kHiddenBands.has(band)) return undefined;
  return kStyles[band] ?? { title: band, ramp: 'much' };
}

/** Three digits of what the scale spans: more would only tell cells apart that have one colour. */
function numberText(value: number, { min, max }: ColourScale): string {
  const decimals = Math.min(6, Math.max(0, 2 - Math.floor(Math.log10(max - min))));
  const text = value.toFixed(decimals);
  // No minus sign before a zero.
  return Number(text) === 0 ? (0).toFixed(decimals) : text;
}

function clockText(hours: number): string {
  const minutes = Math.round(hours * 60);
  return [Math.floor(minutes / 60), minutes % 60].map((v) => String(v).padStart(2, '0')).join(':');
}

/** A value with its unit. */
export function valueText(
  value: number,
  unit: string,
  style: BandStyle,
  scale: ColourScale,
): string {
  if (style.isClock) return clockText(value);
  if (style.words) return style.words[value > 0 ? 1 : 0];
  const text = numberText(value, scale);
  if (unit === 'degree') return `${text}°`;
  return unit === '' ? text : `${text} ${unit}`;
}

/** What cells without colour are; empty where only their lack of a value can be meant. */
export function colourlessText({ words }: BandStyle, hasHoles: boolean): string {
  if (hasHoles) {
    const others = words ? `, or are: ${words[0]}` : '';
    return `Some data could not be read: cells without colour have no value${others}.`;
  }
  return words ? `Cells without colour are: ${words[0]}.` : '';
}
