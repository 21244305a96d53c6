#!/usr/bin/env node
import { setFlagsFromString } from 'node:v8';
import { run } from './cli/program.js';
import { kExit } from './cli/context.js';
import { describeError } from './util/errors.js';

// By default the heap grows to four times the live objects before garbage is collected; with twice,
// a run over a country needs less than 200 MB and no more time.
setFlagsFromString('--heap-growing-percent=100');

const stop = new AbortController();
let interruptedBy: 'SIGINT' | 'SIGTERM' | undefined;

for (const name of ['SIGINT', 'SIGTERM'] as const) {
  // Once: a second signal finds Node's own handler, which ends the process at once.
  process.once(name, () => {
    interruptedBy ??= name;
    stop.abort(new Error(`stopped by ${name}; the next run continues`));
  });
}

// A reader that goes away (| head) ends the work without a stack trace.
process.stdout.on('error', (error) =>
  stop.abort(new Error('write to standard output', { cause: error })),
);

try {
  const streams = {
    out: (text: string) => void process.stdout.write(text),
    err: (text: string) => void process.stderr.write(text),
  };
  process.exitCode = await run(process.argv.slice(2), streams, stop.signal);
} catch (error) {
  process.stderr.write(`error: ${describeError(error)}\n`);
  if (interruptedBy === undefined) process.exitCode = kExit.failed;
  else process.exitCode = interruptedBy === 'SIGINT' ? kExit.interrupted : kExit.terminated;
}
