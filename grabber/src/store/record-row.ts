import {
  kStates,
  type BoundsM,
  type ImageFacts,
  type LastError,
  type PointFacts,
  type StoreRecord,
  type StoredFile,
} from '../model/square.js';
import { kFilePath, kNamePattern, type FileKind } from './layout.js';
import { RowReader, type Row } from './row-reader.js';

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
