import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import assert from 'node:assert/strict';
import * as fc from 'fast-check';
import { arrived, arbitraryDamage } from '../damage.js';
import type { HttpResponse } from '../../../../grabber/src/fetch/http-client.js';
import { GrabberError, type ErrorCode } from '../../../../grabber/src/util/errors.js';

/** A reader of untrusted input, with the properties that must hold for every input. */
export type Target = {
  readonly name: string;
  /** In `npm test`, which takes a few seconds for all targets together. */
  readonly runs: number;
  readonly property: fc.IRawProperty<unknown>;
};

/** A folder for the files of this process, removed at its end. */
export const kFolder = mkdtempSync(join(tmpdir(), 'terravox-fuzz-'));
process.on('exit', () => rmSync(kFolder, { recursive: true, force: true }));

export function target<T>(
  name: string,
  runs: number,
  input: fc.Arbitrary<T>,
  check: (input: T) => unknown,
): Target {
  const property = fc.asyncProperty(input, async (value) => void (await check(value)));
  return { name, runs, property: property as fc.IRawProperty<unknown> };
}

/** Good files and their damaged copies, written to a file of that name. */
export function files(
  name: string,
  runs: number,
  good: readonly Buffer[],
  file: string,
  check: (path: string, bytes: Buffer) => unknown,
): Target {
  return target(name, runs, arbitraryDamage(good.length), (input) => {
    const path = join(kFolder, file);
    const bytes = arrived(good, input);
    writeFileSync(path, bytes);
    return check(path, bytes);
  });
}

export function makeResponse(
  status: number,
  values: Readonly<Record<string, string>>,
  body: Uint8Array = Buffer.alloc(0),
): HttpResponse {
  async function* once(): AsyncGenerator<Uint8Array> {
    yield await Promise.resolve(body);
  }
  return { status, header: (name) => values[name], body: once(), discard: () => Promise.resolve() };
}

/** Messages go to logs and records; an input must not make them as long as it is itself. */
const kMaxMessageLength = 5000;

/**
 * What a reader may do with any input: take it, or refuse it with one of the codes in its contract
 * and a message of one line. Anything else is a fault of the reader.
 * @return what it has read; undefined where it was refused
 */
export async function acceptedOrRefused<T>(
  codes: readonly ErrorCode[],
  read: () => T | Promise<T>,
): Promise<T | undefined> {
  try {
    return await read();
  } catch (error) {
    if (!(error instanceof GrabberError) || !codes.includes(error.code)) {
      throw new Error(`neither taken nor refused with ${codes.join(', ')}`, { cause: error });
    }
    assert.match(error.message, /^\P{Cc}+$/u, 'a message of one line');
    assert.ok(
      error.message.length <= kMaxMessageLength,
      `a message of ${error.message.length} characters`,
    );
    return undefined;
  }
}
