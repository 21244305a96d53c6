import { toRamp, type ColourScale, type Ramp, type ScaleEnds } from './colour-scale.js';

/**
 * How the bands of analyses are drawn: as their rasters say, which is as in the report. That also
 * rounds the ends that the values give.
 */

export type BandStyle = ScaleEnds & {
  readonly title: string;
  readonly ramp: Ramp;
  /** Values are hours of a clock. */
  readonly isClock?: true;
  /** Values are 0 or 1: what these mean. Zero gets no colour. */
  readonly words?: readonly [string, string];
};

/**
 * @param about metadata of a band of a raster; a title says that it can be drawn
 * @return undefined for a band that is not drawn
 */
export function readStyle(about: Readonly<Record<string, string>>): BandStyle | undefined {
  const title = about['terravox_title'];
  const ramp = toRamp(about['terravox_ramp']);
  if (title === undefined || ramp === undefined) return undefined;
  const [low, high] = [about['terravox_low'], about['terravox_high']].map((text) =>
    text === undefined ? undefined : Number(text),
  );
  const words = about['terravox_words']?.split('|');
  return {
    title,
    ramp,
    ...(low !== undefined && { low }),
    ...(high !== undefined && { high }),
    ...(about['terravox_form'] === 'clock' && { isClock: true }),
    ...(words?.length === 2 && { words: words as [string, string] }),
  };
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
