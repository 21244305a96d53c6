import type { StoreRecord } from '../model/square.js';
import type { Store } from '../model/store.js';
import { canConvert, convertRecord, needsConversion, type ConvertTools } from './convert-record.js';
import { loadConverters } from './converters.js';
import { findLazTool, lazTool } from './laz-tool.js';

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
