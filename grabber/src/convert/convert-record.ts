import { mkdir, rename } from 'node:fs/promises';
import { basename, dirname, extname, join } from 'node:path';
import { type LasHeader, toPointFacts } from '../las/header.js';
import { verifyLasFile, type LasFile } from '../las/verify.js';
import type { StoreRecord, StoredFile, Store } from '../model/store.js';
import { GrabberError } from '../util/errors.js';
import { fileSize, removeIfThere, sha256OfFile } from '../util/files.js';
import {
  noZlasConverter,
  type Converters,
  missingLazTool,
  type LazTool,
  loadConverters,
  findLazTool,
  lazTool,
} from './converters.js';
import { flushFile, withWorkFolder } from './work-folder.js';
import { unpackZlas } from './zlas.js';

export type ConvertTools = {
  readonly converters: Converters;
  /** Undefined when it was not found: then only what needs it fails. */
  readonly laz: LazTool | undefined;
  /** In messages. */
  readonly configFolder: string;
};

export type ConvertOptions = {
  /** Write a .lax spatial index where there is none. */
  readonly index: boolean;
  /** Move what was converted to `lidar/<source>/original/` instead of removing it. */
  readonly keepOriginal: boolean;
};

export type Converted = {
  readonly from: string;
  readonly file: StoredFile;
  readonly warnings: readonly string[];
};

/** Whether a file is in a form that is not kept. */
export function needsConversion(record: StoreRecord): boolean {
  return (
    record.file !== null && ['.las', '.zlas'].includes(extname(record.file.path).toLowerCase())
  );
}

/** Whether the program that the conversion begins with is there. */
export function canConvert(record: StoreRecord, tools: ConvertTools): boolean {
  const isZlas = extname(record.file?.path ?? '').toLowerCase() === '.zlas';
  return isZlas ? tools.converters.zlas !== undefined : tools.laz !== undefined;
}

/**
 * Converts the file of one record to the form that is kept, LAZ. The result is checked, renamed
 * into place and recorded, in this order, before the original is removed: after a kill at any
 * moment the store holds a file that a record names. The row keeps length and hash of the original.
 * @return undefined when the file needs no conversion
 * @throws GrabberError COMMAND, CONVERTER, NO_CONVERTER or STORE_IO
 */
export async function convertRecord(
  record: StoreRecord,
  store: Store,
  tools: ConvertTools,
  options: ConvertOptions,
  signal: AbortSignal,
): Promise<Converted | undefined> {
  const file = record.file;
  if (file === null || !needsConversion(record)) return undefined;
  const original = join(store.root, file.path);
  await requireIntact(original, file, signal);
  return withWorkFolder(store.root, async (folder) => {
    const made = await makeLaz(original, record, tools, folder, signal);
    const path = file.path.replace(/\.[^./]+$/, '.laz');
    const final = join(store.root, path);
    const stored = {
      path,
      bytes: (await fileSize(made.path)) ?? 0,
      sha256: await sha256OfFile(made.path, signal),
    };
    await flushFile(made.path);
    await removeIfThere(laxPath(final));
    await rename(made.path, final);
    const warnings = [...record.warnings, ...made.warnings];
    store.squares.converted(record.key, stored, {
      points: toPointFacts(made.header),
      image: null,
      crs: made.header.crs ?? null,
      warnings,
    });
    await keepOrRemove(original, options.keepOriginal);
    return { from: file.path, file: stored, warnings: made.warnings };
  });
}

/**
 * Writes the .lax file of a record's LAZ file, once.
 * @return its path, undefined where there is nothing to do
 */
export async function indexRecord(
  record: StoreRecord,
  store: Store,
  tools: ConvertTools,
  signal: AbortSignal,
): Promise<string | undefined> {
  if (record.file === null || extname(record.file.path).toLowerCase() !== '.laz') return undefined;
  const cloud = join(store.root, record.file.path);
  const lax = laxPath(cloud);
  if ((await fileSize(lax)) !== undefined) return undefined;
  const { laz } = tools;
  if (laz === undefined) throw missingLazTool(`index ${record.file.path}`);
  return withWorkFolder(store.root, async (folder) => {
    if (await laz.isCopc(cloud, folder, signal)) return undefined;
    await laz.index(cloud, folder, signal);
    return lax;
  });
}

export function laxPath(cloud: string): string {
  return cloud.replace(/\.[^./]+$/, '.lax');
}

type MadeLaz = {
  readonly path: string;
  readonly header: LasFile;
  readonly warnings: readonly string[];
};

async function makeLaz(
  original: string,
  record: StoreRecord,
  tools: ConvertTools,
  folder: string,
  signal: AbortSignal,
): Promise<MadeLaz> {
  const shown = record.file?.path ?? original;
  const { laz } = tools;
  let plain: MadeLaz;
  if (extname(original).toLowerCase() === '.zlas') {
    if (tools.converters.zlas === undefined) throw noZlasConverter(shown, tools.configFolder);
    plain = await unpackZlas(original, record, tools.converters.zlas, folder, signal);
  } else {
    plain = { path: original, header: await verifyLasFile(original, shown, signal), warnings: [] };
  }
  if (plain.header.compressed) {
    // Without the tool the header and the chunk table have been looked at, which is what is done
    // with a download too.
    if (laz !== undefined) await laz.check(plain.path, folder, signal);
    return plain;
  }
  if (laz === undefined) throw missingLazTool(`compress ${shown}`);
  const path = join(folder, 'compressed.laz');
  await laz.compress(plain.path, path, folder, signal);
  const header = await verifyLasFile(path, `${shown}, compressed`, signal);
  const same = header.pointCount === plain.header.pointCount && sameBounds(header, plain.header);
  if (!same) {
    throw new GrabberError(
      'CONVERTER',
      `compress ${shown}: the result's header says something else; allowed: the same ` +
        'points and bounds',
    );
  }
  return { path, header, warnings: plain.warnings };
}

async function requireIntact(path: string, file: StoredFile, signal: AbortSignal): Promise<void> {
  const bytes = await fileSize(path);
  if (bytes === file.bytes && (await sha256OfFile(path, signal)) === file.sha256) return;
  throw new GrabberError(
    'STORE_IO',
    `convert ${file.path}: ` +
      `${bytes === undefined ? 'it is gone' : 'its bytes are not those that were fetched'}; ` +
      `allowed: ${file.bytes} bytes with SHA-256 ${file.sha256}`,
  );
}

async function keepOrRemove(original: string, keep: boolean): Promise<void> {
  if (!keep) return removeIfThere(original);
  // In the same folder, programs that read it would take the original for another square.
  const folder = join(dirname(original), 'original');
  await mkdir(folder, { recursive: true });
  await rename(original, join(folder, basename(original)));
}

function sameBounds(a: LasHeader, b: LasHeader): boolean {
  return [0, 1, 2].every((axis) => {
    const sameMin = a.min[axis] === b.min[axis];
    return sameMin && a.max[axis] === b.max[axis];
  });
}

/**
 * What to do with a record whose file was fetched or verified. Nothing, where the file is in its
 * kept form already.
 */
export type Converter = (record: StoreRecord, store: Store, signal: AbortSignal) => Promise<void>;

export type ConverterConfig = {
  readonly configFolder: string;
  /** Folder of the grabber's package.json. */
  readonly packageRoot: string;
};

const kDefaultTimeLimit_s = 3600;

export async function convertTools(
  config: ConverterConfig,
  signal: AbortSignal,
): Promise<ConvertTools> {
  const converters = await loadConverters(config.configFolder, signal);
  const program = await findLazTool(converters, config.packageRoot);
  const time_limit_s = converters.laz?.time_limit_s ?? kDefaultTimeLimit_s;
  return {
    converters,
    laz: program === undefined ? undefined : lazTool(program, time_limit_s),
    configFolder: config.configFolder,
  };
}

/**
 * Makes the conversion that follows a download. Programs are searched once, when the first file
 * needs one. Without them a LAS file stays as it is, which is usable too, and a zLAS file stays in
 * the state fetched; `convert` reports what is missing.
 * @throws by the returned function: GrabberError COMMAND, CONVERTER; the caller records it with
 *   failed()
 */
export function converterFor(config: ConverterConfig): Converter {
  let tools: Promise<ConvertTools> | undefined;
  return async (record, store, signal) => {
    if (!needsConversion(record)) return;
    const found = await (tools ??= convertTools(config, signal));
    if (!canConvert(record, found)) return;
    await convertRecord(record, store, found, { index: false, keepOriginal: false }, signal);
  };
}
