import { kUsable } from '../model/store.js';

const kKey = 'source = @source AND grid = @grid AND name = @name';
const kUsableStates = kUsable.map((state) => `'${state}'`).join(', ');
/**
 * A record that was verified stays usable until another file replaces it.
 * @param otherwise the state of a record that is not usable
 */
const kUsableOr = (otherwise: string): string =>
  `CASE WHEN verified_at IS NULL THEN ${otherwise} WHEN converted_at IS NULL THEN ` +
  "'verified' ELSE 'converted' END";
const kNoError = 'error_code = NULL, error_message = NULL, error_at = NULL';
const kError = 'error_code = @code, error_message = @message, error_at = @now';
const kFacts =
  'point_count = @point_count, las_version = @las_version, point_format = @point_format, ' +
  'min_x = @min_x, min_y = @min_y, min_z = @min_z, max_x = @max_x, max_y = @max_y, max_z = ' +
  '@max_z, ' +
  'image_width_px = @image_width_px, image_height_px = @image_height_px, ' +
  'image_resolution_m = @image_resolution_m, image_margin_m = @image_margin_m';
const kNoFacts = kFacts.replace(/@\w+/g, 'NULL');
const kFile = 'file_path = @path, file_bytes = @bytes, file_sha256 = @sha256';
/** What was left out of a filter is NULL. */
const kFilter =
  '(@source IS NULL OR source = @source) AND (@grid IS NULL OR grid = @grid) ' +
  'AND (@states IS NULL OR state IN (SELECT value FROM json_each(@states))) ' +
  'AND (@names IS NULL OR name IN (SELECT value FROM json_each(@names))) ' +
  'AND (@usable IS NULL OR verified_at IS NOT NULL)';

/** What `learn` compares and writes, by column. */
export const kLearned = [
  'block',
  'west',
  'south',
  'east',
  'north',
  'grid_crs',
  'urls',
  'expected_bytes',
  'expected_sha256',
  'member',
  'published',
  'source_crs',
  'class_table',
  'licence',
  'attribution',
] as const;
/**
 * Columns in the order of the values of `insert`; binding them by name would take most of the time.
 */
const kInserted = ['source', 'grid', 'name', 'geom', 'crs', 'known_at', ...kLearned] as const;

type ReadName = 'get' | 'list' | 'count' | 'tally' | 'unfinished' | 'places' | 'undrawn' | 'errors';
type LearnName = 'learned' | 'insert' | 'relearn' | 'redraw';
type ChangeName =
  | 'want'
  | 'begin'
  | 'located'
  | 'fetched'
  | 'verified'
  | 'converted'
  | 'missing'
  | 'failed'
  | 'forget';
export type RecordSql = Readonly<Record<ReadName | LearnName | ChangeName, string>>;

/**
 * The statements on one table of records. Where a call needs a file, its WHERE requires it, and no
 * row is changed without.
 */
export function recordSql(table: 'squares' | 'orthophotos'): RecordSql {
  return { ...readStatements(table), ...learnStatements(table), ...changeStatements(table) };
}

function readStatements(table: string): Pick<RecordSql, ReadName> {
  return {
    get: `SELECT * FROM ${table} WHERE ${kKey}`,
    list: `SELECT * FROM ${table} WHERE ${kFilter} ORDER BY source, grid, name`,
    count: `SELECT count(*) FROM ${table} WHERE ${kFilter}`,
    tally:
      `SELECT source, ${kUsableOr('state')} AS shown, count(*) AS count, total(file_bytes) ` +
      'AS bytes, total(point_count) AS points ' +
      `FROM ${table} GROUP BY source, shown ORDER BY source, shown`,
    unfinished:
      `SELECT * FROM ${table} WHERE state IN ('wanted', 'fetching', 'fetched') AND ` +
      `${kFilter} ORDER BY source, grid, name`,
    places:
      `SELECT source, grid, ${kUsableOr('state')} AS state, coalesce(west, min_x) AS west, ` +
      'coalesce(south, min_y) AS south, coalesce(east, max_x) AS east, ' +
      `coalesce(north, max_y) AS north FROM ${table} ` +
      'WHERE west IS NOT NULL OR min_x IS NOT NULL ORDER BY source, grid',
    undrawn:
      `SELECT source, grid, name FROM ${table} ` +
      'WHERE geom IS NULL AND west IS NULL AND min_x IS NOT NULL AND crs IS NOT NULL',
    errors:
      `SELECT * FROM ${table} WHERE error_at IS NOT NULL ORDER BY error_at DESC, source, ` +
      'grid, name LIMIT @limit',
  };
}

function learnStatements(table: string): Pick<RecordSql, LearnName> {
  return {
    learned:
      `SELECT fid, geom, warnings, file_path, ${kLearned.join(', ')} FROM ${table} ` +
      `WHERE ${kKey}`,
    insert:
      `INSERT INTO ${table} (${kInserted.join(', ')}, state) VALUES ` +
      `(${kInserted.map(() => '?').join(', ')}, 'known') ON CONFLICT DO NOTHING`,
    relearn:
      `UPDATE ${table} SET ${kLearned.map((name) => `${name} = @${name}`).join(', ')}, ` +
      'warnings = @warnings, ' +
      'crs = CASE WHEN crs IS source_crs THEN @source_crs ELSE crs END WHERE fid = @fid',
    redraw: `UPDATE ${table} SET geom = @geom WHERE fid = @fid`,
  };
}

function changeStatements(table: string): Omit<RecordSql, ReadName | LearnName> {
  const update = (set: string, where = ''): string =>
    `UPDATE ${table} SET ${set} WHERE ${kKey}${where}`;
  return {
    want: update(
      `state = 'wanted', wanted_at = @now, attempts = 0, ${kNoError}`,
      " AND (state IN ('known', 'failed') OR (state = 'missing' AND error_at < @stale) OR " +
        `(@again = 1 AND state IN ('missing', ${kUsableStates})))`,
    ),
    begin: update(
      "state = 'fetching', attempts = attempts + 1, asked_url = @url, url = CASE WHEN " +
        'verified_at IS NULL THEN @url ELSE url END',
    ),
    located: update('block = coalesce(@block, block), urls = @urls'),
    fetched: update(
      `state = 'fetched', ${kFile}, url = coalesce(asked_url, url), original_bytes = NULL, ` +
        `original_sha256 = NULL, ${kNoFacts}, ` +
        "warnings = '[]', fetched_at = @now, verified_at = NULL, converted_at = NULL",
    ),
    verified: update(
      `state = 'verified', ${kFacts}, crs = coalesce(@crs, source_crs), warnings = ` +
        `@warnings, ${kNoError}, verified_at = @now, converted_at = NULL`,
      ' AND file_path IS NOT NULL',
    ),
    // Straight from `fetching` where nothing is kept of what was sent.
    converted: update(
      "original_bytes = CASE state WHEN 'converted' THEN original_bytes WHEN 'fetching' " +
        'THEN NULL ELSE file_bytes END, ' +
        "original_sha256 = CASE state WHEN 'converted' THEN original_sha256 WHEN " +
        "'fetching' THEN NULL ELSE file_sha256 END, " +
        "url = CASE state WHEN 'fetching' THEN asked_url ELSE url END, fetched_at = CASE " +
        "state WHEN 'fetching' THEN @now ELSE fetched_at END, " +
        `verified_at = CASE WHEN state IN (${kUsableStates}) THEN verified_at ELSE @now END, ` +
        `state = 'converted', ${kFile}, ${kFacts}, crs = coalesce(@crs, source_crs), ` +
        `warnings = @warnings, ${kNoError}, converted_at = @now`,
    ),
    missing: update(`state = ${kUsableOr("'missing'")}, ${kError}`),
    // A whole file that cannot be converted is not to be fetched again.
    failed: update(
      `state = ${kUsableOr("CASE state WHEN 'fetched' THEN state ELSE 'failed' END")}, ${kError}`,
    ),
    forget: update(
      "state = 'known', url = NULL, asked_url = NULL, file_path = NULL, file_bytes = NULL, " +
        'file_sha256 = NULL, ' +
        'original_bytes = NULL, original_sha256 = NULL, ' +
        `${kNoFacts}, crs = source_crs, warnings = '[]', ${kNoError}, attempts = 0, ` +
        'wanted_at = NULL, fetched_at = NULL, verified_at = NULL, converted_at = NULL',
    ),
  };
}
