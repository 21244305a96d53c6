import { test } from 'node:test';
import * as fc from 'fast-check';
import { allTargets } from './targets.js';

/** The same inputs in every run: `npm run fuzz` looks for others. */
const kSeed = Number(process.env['TERRAVOX_FUZZ_SEED'] ?? 1);
const kTimes = Number(process.env['TERRAVOX_FUZZ_TIMES'] ?? 1);

for (const { name, runs, property } of allTargets()) {
  test(`any input of ${name} is taken, or refused as its reader documents`, async () => {
    await fc.assert(property, { seed: kSeed, numRuns: runs * kTimes, includeErrorInReport: true });
  });
}
