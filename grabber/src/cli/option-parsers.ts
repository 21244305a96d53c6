import { InvalidArgumentError } from 'commander';
import type { BoundsDeg } from '../geo/bounds.js';
import type { BoundsM } from '../model/square.js';
import { kSourceId, kSourceIdAllowed } from '../sources/source.js';
import type { Variables } from '../sources/url-template.js';

/** Commander puts "option '--x' argument 'v' is invalid." before these messages. */
export function integerIn(low: number, high: number, unit: string): (text: string) => number {
  return (text) => {
    const value = Number(text);
    if (/^\d+$/.test(text) && value >= low && value <= high) return value;
    throw new InvalidArgumentError(`allowed: an integer from ${low} to ${high}, ${unit}`);
  };
}

export function parseNameList(text: string): string[] {
  const names = text.split(',').map((name) => name.trim());
  if (names.some((name) => name === '')) {
    throw new InvalidArgumentError('allowed: names separated by commas, none empty');
  }
  return [...new Set(names)];
}

/** @return exactly `count` finite numbers, or undefined */
function parseNumbers(text: string, count: number): number[] | undefined {
  const parts = text.split(',').map((part) => part.trim());
  const numbers = parts.map(Number);
  return parts.length === count &&
    parts.every((part) => part !== '') &&
    numbers.every(Number.isFinite)
    ? numbers
    : undefined;
}

export function parseBox(text: string): BoundsM {
  const [west, south, east, north] = parseNumbers(text, 4) ?? [];
  if (
    west !== undefined &&
    south !== undefined &&
    east !== undefined &&
    north !== undefined &&
    west < east &&
    south < north
  ) {
    return [west, south, east, north];
  }
  throw new InvalidArgumentError(
    "allowed: west,south,east,north, four numbers in metres of the source's CRS, west < " +
      'east and south < north',
  );
}

export function parseBoxDeg(text: string): BoundsDeg {
  const [west = NaN, south = NaN, east = NaN, north = NaN] = parseNumbers(text, 4) ?? [];
  if (west >= -180 && west < east && east <= 180 && south >= -85 && south < north && north <= 85) {
    return [west, south, east, north];
  }
  throw new InvalidArgumentError(
    'allowed: west,south,east,north in degrees, -180 to 180 and -85 to 85, west < east and ' +
      'south < north',
  );
}

type Circle = readonly [number, number, number];
const kMaxRadius_m = 200_000;

export function parseCircle(text: string): Circle {
  const [east, north, radius] = parseNumbers(text, 3) ?? [];
  if (
    east !== undefined &&
    north !== undefined &&
    radius !== undefined &&
    radius > 0 &&
    radius <= kMaxRadius_m
  ) {
    return [east, north, radius];
  }
  throw new InvalidArgumentError(
    `allowed: east,north,radius in metres of the source's CRS, radius at most ${kMaxRadius_m}`,
  );
}

export function parseCircleDeg(text: string): Circle {
  const [lon = NaN, lat = NaN, radius = NaN] = parseNumbers(text, 3) ?? [];
  if (
    lon >= -180 &&
    lon <= 180 &&
    lat >= -85 &&
    lat <= 85 &&
    radius > 0 &&
    radius <= kMaxRadius_m
  ) {
    return [lon, lat, radius];
  }
  throw new InvalidArgumentError(
    'allowed: longitude,latitude,radius in degrees and metres, -180 to 180 and -85 to 85, ' +
      `radius at most ${kMaxRadius_m}`,
  );
}

/** Collects a repeatable `--set name=value`. */
export function collectVariable(text: string, before: Variables = {}): Variables {
  const match = /^([a-z][a-z0-9_]*)=(.+)$/.exec(text);
  if (match?.[1] === undefined || match[2] === undefined) {
    throw new InvalidArgumentError('allowed: name=value, such as region=04-jesenice');
  }
  return { ...before, [match[1]]: match[2] };
}

export function parseStatusList(text: string): number[] {
  return parseNameList(text).map(integerIn(400, 499, 'HTTP statuses separated by commas'));
}

export function parseSourceId(text: string): string {
  if (kSourceId.test(text)) return text;
  throw new InvalidArgumentError(`allowed: ${kSourceIdAllowed}`);
}

export function parseCrs(text: string): string {
  if (/^EPSG:\d{4,6}$/.test(text)) return text;
  throw new InvalidArgumentError('allowed: EPSG:<number>, such as EPSG:3794');
}
