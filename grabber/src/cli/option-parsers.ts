import { InvalidArgumentError } from 'commander';
import { kSourceId, kSourceIdAllowed } from '../sources/source.js';
import type { BoundsM } from '../sources/square.js';
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

export function parseBox(text: string): BoundsM {
  const parts = text.split(',').map((part) => part.trim());
  const numbers = parts.map(Number);
  const [west, south, east, north] = numbers;
  const fits = parts.length === 4 && parts.every((part) => part !== '') && numbers.every(Number.isFinite);
  if (!fits || west === undefined || south === undefined || east === undefined || north === undefined) {
    throw new InvalidArgumentError("allowed: west,south,east,north, four numbers in metres of the source's CRS");
  }
  return [west, south, east, north];
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
