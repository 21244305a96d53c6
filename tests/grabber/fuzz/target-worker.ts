import * as fc from 'fast-check';
import type { TargetMessage } from './target-process.js';
import { allTargets, type Target } from './targets.js';

// The child process of one fuzz target: target-worker.js NAME SECONDS SEED. It reports to its
// parent over the channel that fork() opens.

/** The end of the target's time is checked after each series of inputs, so a series is short. */
const kMaxSeriesRuns = 100;
/**
 * An input that takes longer is a find, because such inputs could keep the reader busy. It is far
 * from what any input needs: a busy machine is no find.
 */
const kInputTimeout_ms = 120_000;

/**
 * Resolves when the message is written, so that it is not lost if the next input ends the process.
 */
function send(message: TargetMessage): Promise<void> {
  return new Promise((resolve, reject) => {
    process.send?.(message, undefined, undefined, (error) => {
      if (error === null) resolve();
      else reject(error);
    });
  });
}

/** Runs series of inputs until the time is over or an input is a find; at least one series. */
async function runTarget(target: Target, seconds: number, seed: number): Promise<void> {
  const end_ms = Date.now() + seconds * 1000;
  let runs = 0;
  let series = seed;
  do {
    await send({ kind: 'series', runs, seed: series });
    const details = await fc.check(target.property, {
      seed: series,
      numRuns: Math.min(target.runs, kMaxSeriesRuns),
      timeout: kInputTimeout_ms,
      includeErrorInReport: true,
    });
    runs += details.numRuns;
    if (details.failed) {
      const report = fc.defaultReportMessage(details) ?? 'the property failed';
      await send({ kind: 'find', runs, report });
      return;
    }
    series += 1;
  } while (Date.now() < end_ms);
  await send({ kind: 'end', runs });
}

// Without its parent, nothing would end this process early.
process.on('disconnect', () => process.exit(1));
const [name, seconds, seed] = process.argv.slice(2);
const target = allTargets().find((one) => one.name === name);
if (target === undefined) throw new Error(`fuzz: no target is called "${name}"`);
await runTarget(target, Number(seconds), Number(seed));
process.exit(0);
