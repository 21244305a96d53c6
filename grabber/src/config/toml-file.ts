import { readFile } from 'node:fs/promises';
import { basename, join } from 'node:path';
import { parse } from 'smol-toml';
import type { z } from 'zod';
import { GrabberError, causedError } from '../util/errors.js';
import { namesInFolder } from '../util/files.js';

/** A kind of configuration file: one a thing, named after its id. */
export type ConfigKind<T extends { readonly id: string }> = {
  /** In messages, such as "source". */
  readonly what: string;
  readonly schema: z.ZodType<T>;
  /**
   * What each field may hold, by its path ("access.urls") or the nearest part of it that is listed
   * ("access").
   */
  readonly allowed: Readonly<Record<string, string>>;
};

/**
 * Reads every `*.toml` file of a folder, sorted by id. One invalid file fails all of them, since a
 * source that is silently missing would leave holes.
 * @throws GrabberError CONFIG
 */
export async function loadConfigFolder<T extends { readonly id: string }>(
  folder: string,
  kind: ConfigKind<T>,
  signal: AbortSignal,
): Promise<ReadonlyMap<string, T>> {
  let names: string[];
  try {
    names = await namesInFolder(folder, '.toml');
  } catch (error) {
    const attempt = `read ${kind.what}s folder ${folder}`;
    throw causedError('CONFIG', attempt, error, 'a folder of *.toml files');
  }
  const found = new Map<string, T>();
  for (const name of names) {
    const path = join(folder, name);
    const one = parseConfig(await readFile(path, { encoding: 'utf8', signal }), path, kind);
    found.set(one.id, one);
  }
  return new Map([...found].sort(([a], [b]) => (a < b ? -1 : 1)));
}

/** @param path used for messages, and its stem must be the id */
export function parseConfig<T extends { readonly id: string }>(
  toml: string,
  path: string,
  kind: ConfigKind<T>,
): T {
  let raw: unknown;
  try {
    raw = parse(toml);
  } catch (error) {
    throw causedError('CONFIG', `read ${kind.what} ${path}: not TOML`, error);
  }
  const result = kind.schema.safeParse(raw);
  // The schema's own words are for programmers, and would follow the message as its cause.
  if (!result.success) {
    throw new GrabberError('CONFIG', describeProblem(path, raw, result.error, kind));
  }
  if (result.data.id !== basename(path, '.toml')) {
    throw new GrabberError(
      'CONFIG',
      fieldMessage(kind, path, 'id', result.data.id, allowedAt(kind, ['id'])),
    );
  }
  return result.data;
}

function describeProblem<T extends { readonly id: string }>(
  path: string,
  raw: unknown,
  error: z.ZodError,
  kind: ConfigKind<T>,
): string {
  const issue = error.issues[0];
  if (issue === undefined) return `read ${kind.what} ${path}: not a ${kind.what}`;
  const where = issue.path.map(String);
  if (issue.code === 'unrecognized_keys') {
    const key = [...where, issue.keys[0] ?? ''];
    return fieldMessage(kind, path, key.join('.'), valueAt(raw, key), allowedAt(kind, where));
  }
  const allowed = allowedAt(kind, where);
  // The message of a refinement names the fault, and what the field may hold follows.
  const custom =
    issue.code === 'custom' && issue.message !== 'Invalid input'
      ? `${issue.message} (${allowed})`
      : undefined;
  if (custom === undefined) {
    return fieldMessage(kind, path, where.join('.'), valueAt(raw, where), allowed);
  }
  return (
    `read ${kind.what} ${path}: field ${where.join('.')} is ` +
    `${JSON.stringify(valueAt(raw, where))}, which has ${custom}`
  );
}

function fieldMessage<T extends { readonly id: string }>(
  kind: ConfigKind<T>,
  path: string,
  field: string,
  value: unknown,
  allowed: string,
): string {
  const shown = value === undefined ? 'missing' : JSON.stringify(value);
  return `read ${kind.what} ${path}: field ${field} is ${shown}; allowed: ${allowed}`;
}

/** The allowed values of a field, or of the nearest table around it. */
function allowedAt<T extends { readonly id: string }>(
  kind: ConfigKind<T>,
  where: readonly string[],
): string {
  for (let length = where.length; length > 0; --length) {
    const words = kind.allowed[where.slice(0, length).join('.')];
    if (words !== undefined) return words;
  }
  const fields = Object.keys(kind.allowed).filter((name) => !name.includes('.'));
  return `the fields ${fields.join(', ')}`;
}

function valueAt(raw: unknown, path: readonly string[]): unknown {
  let value = raw;
  for (const key of path) {
    if (typeof value !== 'object' || value === null) return undefined;
    value = (value as Record<string, unknown>)[key];
  }
  return value;
}
