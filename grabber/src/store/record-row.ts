import {
  kStates,
  type BoundsM,
  type ImageFacts,
  type LastError,
  type PointFacts,
  type StoreRecord,
  type StoredFile,
  type RecordKey,
  type Verified,
} from '../model/store.js';
import { kFilePath, kNamePattern, type FileKind } from './layout.js';
import { GrabberError } from '../util/errors.js';

const kSha256 = /^[0-9a-f]{64}$/;
const kSha256Allowed = '64 lower-case hexadecimal digits';
/** As toISOString writes it, and as GIS programs do. */
const kTime = /^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d{1,9})?Z$/;

/**
 * @param table for messages
 * @throws GrabberError STORE_DAMAGED, naming row and column
 */
export function recordOfRow(row: Row, table: string, kind: FileKind): StoreRecord {
  const key = [row['source'], row['grid'], row['name']].map(String).join('/');
  const read = new RowReader(row, `${table} ${key}`);
  return {
    key: { source: name(read, 'source'), grid: name(read, 'grid'), name: name(read, 'name') },
    state: read.readChoice('state', kStates),
    block: read.labelOrNull('block'),
    bounds: bounds(read),
    gridCrs: read.labelOrNull('grid_crs'),
    urls: read.texts('urls'),
    expectedBytes: read.countOrNull('expected_bytes'),
    expectedSha256: sha256OrNull(read, 'expected_sha256'),
    member: read.textOrNull('member'),
    published: read.textOrNull('published'),
    crs: read.labelOrNull('crs'),
    classTable: read.labelOrNull('class_table'),
    licence: read.labelOrNull('licence'),
    attribution: read.labelOrNull('attribution'),
    url: read.textOrNull('url'),
    file: file(read, kind),
    original: original(read),
    points: points(read),
    image: image(read),
    warnings: read.texts('warnings'),
    lastError: lastError(read),
    attempts: read.count('attempts'),
    knownAt: time(read, 'known_at') ?? read.fail('known_at', 'a time'),
    wantedAt: time(read, 'wanted_at'),
    fetchedAt: time(read, 'fetched_at'),
    verifiedAt: time(read, 'verified_at'),
    convertedAt: time(read, 'converted_at'),
  };
}

function name(read: RowReader, column: string): string {
  return read.matching(column, kNamePattern, 'a name that can be part of a path');
}

function bounds(read: RowReader): BoundsM | null {
  if (['west', 'south', 'east', 'north'].every((column) => read.isNull(column))) return null;
  const west = read.number('west');
  const south = read.number('south');
  const east = read.number('east');
  const north = read.number('north');
  if (west >= east) read.fail('east', `above west, ${west}`);
  if (south >= north) read.fail('north', `above south, ${south}`);
  return [west, south, east, north];
}

function file(read: RowReader, kind: FileKind): StoredFile | null {
  if (read.isNull('file_path')) return null;
  return {
    // Files are read and removed by this path.
    path: read.matching('file_path', kFilePath[kind].pattern, kFilePath[kind].allowed),
    bytes: read.count('file_bytes'),
    sha256: read.matching('file_sha256', kSha256, kSha256Allowed),
  };
}

function original(read: RowReader): StoreRecord['original'] {
  if (read.isNull('original_bytes')) return null;
  return {
    bytes: read.count('original_bytes'),
    sha256: read.matching('original_sha256', kSha256, kSha256Allowed),
  };
}

function points(read: RowReader): PointFacts | null {
  if (read.isNull('point_count')) return null;
  const pointFormat = read.count('point_format');
  if (pointFormat > 10) read.fail('point_format', '0 to 10');
  return {
    pointCount: read.count('point_count'),
    lasVersion: read.matching('las_version', /^1\.[0-4]$/, '1.0 to 1.4'),
    pointFormat,
    min: [read.number('min_x'), read.number('min_y'), read.number('min_z')],
    max: [read.number('max_x'), read.number('max_y'), read.number('max_z')],
  };
}

function image(read: RowReader): ImageFacts | null {
  if (read.isNull('image_width_px')) return null;
  return {
    width_px: read.count('image_width_px'),
    height_px: read.count('image_height_px'),
    resolution_m: read.number('image_resolution_m'),
    margin_m: read.number('image_margin_m'),
  };
}

function lastError(read: RowReader): LastError | null {
  if (read.isNull('error_code')) return null;
  return {
    code: read.text('error_code'),
    message: read.text('error_message'),
    at: time(read, 'error_at') ?? read.fail('error_at', 'a time'),
  };
}

function sha256OrNull(read: RowReader, column: string): string | null {
  return read.isNull(column) ? null : read.matching(column, kSha256, kSha256Allowed);
}

function time(read: RowReader, column: string): string | null {
  return read.isNull(column)
    ? null
    : read.matching(column, kTime, 'a time such as 2026-01-31T12:00:00.000Z');
}

/** Only the key's own fields, whatever else the object has. */
export function toKey(key: RecordKey): { source: string; grid: string; name: string } {
  return { source: key.source, grid: key.grid, name: key.name };
}

/** What was found in a file, as columns. */
export function toFacts({
  points,
  image,
  crs,
  warnings,
}: Verified): Record<string, string | number | null> {
  return {
    point_count: points?.pointCount ?? null,
    las_version: points?.lasVersion ?? null,
    point_format: points?.pointFormat ?? null,
    min_x: points?.min[0] ?? null,
    min_y: points?.min[1] ?? null,
    min_z: points?.min[2] ?? null,
    max_x: points?.max[0] ?? null,
    max_y: points?.max[1] ?? null,
    max_z: points?.max[2] ?? null,
    image_width_px: image?.width_px ?? null,
    image_height_px: image?.height_px ?? null,
    image_resolution_m: image?.resolution_m ?? null,
    image_margin_m: image?.margin_m ?? null,
    crs,
    warnings: JSON.stringify(warnings),
  };
}

const kLabels = new Map<string, string>();
const kMaxLabels = 1000;

export type Row = Readonly<Record<string, unknown>>;

/**
 * Reads columns of one row, each with its type: a damaged or foreign row is an error that names it,
 * never a guess.
 */
export class RowReader {
  readonly #row: Row;
  readonly #shown: string;

  /** @param shown names the row in messages, such as "squares si-lss/si-lss/462_101" */
  constructor(row: Row, shown: string) {
    this.#row = row;
    this.#shown = shown;
  }

  text(column: string): string {
    return this.textOrNull(column) ?? this.fail(column, 'text');
  }

  textOrNull(column: string): string | null {
    const value = this.#row[column];
    return value === null || typeof value === 'string' ? value : this.fail(column, 'text');
  }

  /** Reads text that many rows share; all rows refer to one copy. */
  labelOrNull(column: string): string | null {
    const text = this.textOrNull(column);
    if (text === null) return null;
    const known = kLabels.get(text);
    if (known !== undefined) return known;
    if (kLabels.size >= kMaxLabels) kLabels.clear();
    kLabels.set(text, text);
    return text;
  }

  /** From 0 to 2^53 - 1. */
  count(column: string): number {
    return this.countOrNull(column) ?? this.fail(column, 'a count');
  }

  countOrNull(column: string): number | null {
    const value = this.#row[column];
    if (value === null || (Number.isSafeInteger(value) && (value as number) >= 0)) {
      return value as number | null;
    }
    return this.fail(column, 'an integer from 0 to 2^53 - 1');
  }

  number(column: string): number {
    const value = this.#row[column];
    return typeof value === 'number' && Number.isFinite(value)
      ? value
      : this.fail(column, 'a finite number');
  }

  isNull(column: string): boolean {
    return this.#row[column] === null;
  }

  readChoice<T extends string>(column: string, allowed: readonly T[]): T {
    const value = this.#row[column];
    return allowed.find((one) => one === value) ?? this.fail(column, allowed.join(', '));
  }

  matching(column: string, pattern: RegExp, allowed: string): string {
    const value = this.text(column);
    return pattern.test(value) ? value : this.fail(column, allowed);
  }

  /** A JSON list. */
  texts(column: string): string[] {
    const allowed = 'a JSON list of texts';
    let value: unknown;
    try {
      value = JSON.parse(this.text(column));
    } catch (error) {
      if (error instanceof GrabberError) throw error;
      return this.fail(column, allowed);
    }
    if (Array.isArray(value) && value.every((one) => typeof one === 'string')) {
      return value;
    }
    return this.fail(column, allowed);
  }

  fail(column: string, allowed: string): never {
    const shown = shownValue(this.#row[column]).slice(0, 200);
    throw new GrabberError(
      'STORE_DAMAGED',
      `read ${this.#shown}: ${column} is ${shown}; allowed: ${allowed}`,
    );
  }
}

function shownValue(value: unknown): string {
  if (value === undefined) return 'missing';
  return value instanceof Uint8Array ? `${value.length} bytes` : JSON.stringify(value);
}
