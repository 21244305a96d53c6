import { readFile } from 'node:fs/promises';
import { basename, join } from 'node:path';
import { parse } from 'smol-toml';
import type { z } from 'zod';
import { GrabberError, describeError } from '../util/errors.js';
import { namesInFolder } from '../util/files.js';
import { kAllowed, sourceSchema, type Source } from './source.js';

/** Reads every `*.toml` of a folder. One bad file fails all: a source that vanishes quietly would be a hole. */
export async function loadSources(folder: string, signal: AbortSignal): Promise<ReadonlyMap<string, Source>> {
  let names: string[];
  try {
    names = await namesInFolder(folder, '.toml');
  } catch (error) {
    throw new GrabberError(
      'CONFIG',
      `read sources folder ${folder}: ${describeError(error)}; allowed: a folder of *.toml files`,
      { cause: error },
    );
  }
  const sources = new Map<string, Source>();
  for (const name of names) {
    const path = join(folder, name);
    const source = parseSource(await readFile(path, { encoding: 'utf8', signal }), path);
    sources.set(source.id, source);
  }
  return new Map([...sources].sort(([a], [b]) => (a < b ? -1 : 1)));
}

/** @param path used for messages, and its stem must be the source's id */
export function parseSource(toml: string, path: string): Source {
  let raw: unknown;
  try {
    raw = parse(toml);
  } catch (error) {
    throw new GrabberError('CONFIG', `read source ${path}: not TOML: ${describeError(error)}`, { cause: error });
  }
  const result = sourceSchema.safeParse(raw);
  if (!result.success) throw configError(path, raw, result.error);
  if (result.data.id !== basename(path, '.toml')) {
    throw new GrabberError('CONFIG', fieldMessage(path, 'id', result.data.id, kAllowed.id));
  }
  return result.data;
}

function configError(path: string, raw: unknown, error: z.ZodError): GrabberError {
  const issue = error.issues[0];
  if (issue === undefined) return new GrabberError('CONFIG', `read source ${path}: not a source`, { cause: error });
  if (issue.code === 'unrecognized_keys') {
    const where = issue.path.map(String);
    const key = [...where, issue.keys[0] ?? ''];
    const allowed = where.length === 0 ? `the fields ${Object.keys(kAllowed).join(', ')}` : kAllowed.variables;
    return new GrabberError('CONFIG', fieldMessage(path, key.join('.'), valueAt(raw, key), allowed), { cause: error });
  }
  const field = issue.path.map(String);
  const top = field[0] ?? '';
  const known =
    top in kAllowed ? kAllowed[top as keyof typeof kAllowed] : `the fields ${Object.keys(kAllowed).join(', ')}`;
  const allowed = issue.code === 'custom' && top === 'url' ? `${issue.message} (${known})` : known;
  const message =
    issue.code === 'custom' && top === 'url'
      ? `read source ${path}: field url is ${JSON.stringify(valueAt(raw, field))}, which has ${allowed}`
      : fieldMessage(path, field.join('.'), valueAt(raw, field), allowed);
  return new GrabberError('CONFIG', message, { cause: error });
}

function fieldMessage(path: string, field: string, value: unknown, allowed: string): string {
  const shown = value === undefined ? 'missing' : JSON.stringify(value);
  return `read source ${path}: field ${field} is ${shown}; allowed: ${allowed}`;
}

function valueAt(raw: unknown, path: readonly string[]): unknown {
  let value = raw;
  for (const key of path) {
    if (typeof value !== 'object' || value === null) return undefined;
    value = (value as Record<string, unknown>)[key];
  }
  return value;
}
