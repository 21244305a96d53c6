import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import * as fc from 'fast-check';
import { arrived, arbitraryDamage } from '../damage.js';

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
