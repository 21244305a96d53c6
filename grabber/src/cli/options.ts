import { join } from 'node:path';
import { InvalidArgumentError, Option, type Command } from 'commander';
import type { BoundsDeg } from '../geo/bounds.js';
import type { BoundsM } from '../model/store.js';
import { kSourceId, kSourceIdAllowed } from '../sources/source.js';
import type { Variables } from '../sources/square.js';
import type { CliContext } from './context.js';

/** Commander puts "option '--x' argument 'v' is invalid." before these messages. */
export function integerIn(low: number, high: number, unit: string): (text: string) => number {
  return (text) => {
    const value = Number(text);
    if (/^\d+$/.test(text) && value >= low && value <= high) return value;
    throw new InvalidArgumentError(`allowed: an integer from ${low} to ${high}, ${unit}`);
  };
}

export const kSilence = 'longest silence of a server, seconds';

/** An option that takes an integer, whose range its help text names. */
export function limit(
  flags: string,
  about: string,
  low: number,
  high: number,
  unit: string,
  preset: number,
): Option {
  const option = new Option(flags, `${about}, ${low} to ${high}`);
  return option.argParser(integerIn(low, high, unit)).default(preset);
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
  const [west = NaN, south = NaN, east = NaN, north = NaN] = parseNumbers(text, 4) ?? [];
  if (west < east && south < north) return [west, south, east, north];
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
  const [east = NaN, north = NaN, radius = NaN] = parseNumbers(text, 3) ?? [];
  if (radius > 0 && radius <= kMaxRadius_m) return [east, north, radius];
  throw new InvalidArgumentError(
    `allowed: east,north,radius in metres of the source's CRS, radius at most ${kMaxRadius_m}`,
  );
}

export function parseCircleDeg(text: string): Circle {
  const [lon = NaN, lat = NaN, radius = NaN] = parseNumbers(text, 3) ?? [];
  const isPlace = Math.abs(lon) <= 180 && Math.abs(lat) <= 85;
  if (isPlace && radius > 0 && radius <= kMaxRadius_m) return [lon, lat, radius];
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

/** Everything that SelectionOptions holds: which source, which ground. */
export function addSelectionOptions(command: Command, context: CliContext): Command {
  command
    .option('--source <id>', 'source of the squares, one of those that "sources" lists')
    .option('--from <folder>', 'take LAZ, LAS and zLAS files of this folder instead of the web');
  addVariableOptions(addRegionOptions(command, context));
  return command
    .option(
      '--url-template <url>',
      "address to use instead of the source's: {E} {N} km, {x} {y} m, {name}; {x:06} pads",
    )
    .option(
      '--as <id>',
      'without --source: folder name in the store (default: adhoc, or local with --from)',
      parseSourceId,
    )
    .option(
      '--crs <code>',
      'without --source: CRS of files that carry none, such as EPSG:3794',
      parseCrs,
    )
    .option('--licence <text>', 'without --source: licence to record')
    .option('--attribution <text>', 'without --source: attribution to record')
    .addOption(
      new Option(
        '--missing-status <list>',
        'without --source: statuses that mean "no such square" (default: 404)',
      ).argParser(parseStatusList),
    )
    .option(
      '--allow-private',
      'without --source: this address (scheme, host, port) may be in a private network, or ' +
        'on this machine',
    );
}

/** Which ground; exactly one of them chooses. */
export function addRegionOptions(command: Command, context: CliContext): Command {
  return command
    .option('--area <name>', 'a named area, one of those that "areas" lists, such as Bled')
    .option(
      '--squares <names>',
      'squares E_N (south-west corner, km) or ranges E_N:E_N, separated by commas',
      parseNameList,
    )
    .option(
      '--bbox <w,s,e,n>',
      "all squares that touch this box, metres in the source's CRS",
      parseBox,
    )
    .option('--bbox-deg <w,s,e,n>', 'all squares that touch this box, degrees', parseBoxDeg)
    .option(
      '--circle <e,n,r>',
      "all squares that touch this circle, metres in the source's CRS",
      parseCircle,
    )
    .option(
      '--circle-deg <lon,lat,r>',
      'all squares that touch this circle, degrees and metres',
      parseCircleDeg,
    )
    .option(
      '--polygon <file>',
      'all squares that touch the polygons of a Shapefile, GeoJSON, GeoPackage, FlatGeobuf ' +
        'or KML file',
    )
    .hook('preAction', () => {
      command.setOptionValue('areasFolder', join(context.configFolder(), 'areas'));
    });
}

/** What addresses leave open. */
export function addVariableOptions(command: Command): Command {
  return command
    .option('--block <name>', 'short for --set block=<name>')
    .option(
      '--set <name=value>',
      "value of a source's own placeholder; may be repeated",
      collectVariable,
    );
}
