import { loadConfigFolder, parseConfig, type ConfigKind } from '../config/toml-file.js';
import { kAllowed, sourceSchema, type Source } from './source.js';

const kKind: ConfigKind<Source> = { what: 'source', schema: sourceSchema, allowed: kAllowed };

export function loadSources(
  folder: string,
  signal: AbortSignal,
): Promise<ReadonlyMap<string, Source>> {
  return loadConfigFolder(folder, kKind, signal);
}

/** @param path used for messages, and its stem must be the source's id */
export function parseSource(toml: string, path: string): Source {
  return parseConfig(toml, path, kKind);
}
