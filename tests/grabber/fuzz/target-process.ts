import { fork, type ChildProcess } from 'node:child_process';
import { mkdirSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { bothEnds } from '../../../grabber/src/util/errors.js';

/** What the process of a target reports: before each series of inputs, and at its end. */
export type TargetMessage =
  | { readonly kind: 'series'; readonly runs: number; readonly seed: number }
  | { readonly kind: 'find'; readonly runs: number; readonly report: string }
  | { readonly kind: 'end'; readonly runs: number };

export type TargetResult = {
  /** How many inputs the target was given; without the last series if that ended the process. */
  readonly runs: number;
  /** What is wrong, and how to repeat it; undefined when nothing was found. */
  readonly find: string | undefined;
};

export type TargetLimits = { readonly seconds: number; readonly seed: number };

const kWorker = fileURLToPath(new URL('target-worker.js', import.meta.url));
/** A reader that needs more memory than this for an input of a few KiB is a find. */
const kMaxHeap_mb = 512;
/**
 * A series of inputs takes seconds. One that takes longer than this is a find; the limit is far
 * above, since a busy machine is none.
 */
const kSeriesTimeout_ms = 600_000;
const kMaxErrorText = 2000;

/** Starts the processes of targets, and removes what they leave behind. */
export class TargetProcesses {
  readonly #folder = mkdtempSync(join(tmpdir(), 'terravox-fuzz-'));
  readonly #children = new Set<ChildProcess>();
  readonly #worker: string;

  /** @param worker the script that runs one target; given NAME SECONDS SEED */
  constructor(worker: string = kWorker) {
    this.#worker = worker;
  }

  /** Runs one target in a child process; may be called for several targets at a time. */
  async run(name: string, { seconds, seed }: TargetLimits): Promise<TargetResult> {
    const scratch = join(this.#folder, name);
    mkdirSync(scratch, { recursive: true });
    const child = fork(this.#worker, [name, String(seconds), String(seed)], {
      execArgv: [`--max-old-space-size=${kMaxHeap_mb}`],
      env: { ...process.env, TMPDIR: scratch },
      stdio: ['ignore', 'ignore', 'pipe', 'ipc'],
    });
    this.#children.add(child);
    try {
      return await waitForResult(child, name, seed);
    } finally {
      this.#children.delete(child);
      rmSync(scratch, { recursive: true, force: true });
    }
  }

  /** Ends all processes and removes their files; idempotent. */
  close(): void {
    for (const child of this.#children) child.kill('SIGKILL');
    rmSync(this.#folder, { recursive: true, force: true, maxRetries: 3 });
  }
}

/** Waits for the end of a target's process; the process itself is the find if it ends early. */
function waitForResult(
  child: ChildProcess,
  name: string,
  firstSeed: number,
): Promise<TargetResult> {
  let result: TargetResult | undefined;
  let runs = 0;
  let seed = firstSeed;
  let errorText = '';
  let timedOut = false;
  const endChild = (): void => {
    timedOut = true;
    child.kill('SIGKILL');
  };
  let timer = setTimeout(endChild, kSeriesTimeout_ms);
  child.stderr?.setEncoding('utf8').on('data', (text: string) => {
    errorText = bothEnds(errorText + text, kMaxErrorText);
  });
  child.on('message', (message: TargetMessage) => {
    clearTimeout(timer);
    runs = message.runs;
    if (message.kind === 'series') {
      seed = message.seed;
      timer = setTimeout(endChild, kSeriesTimeout_ms);
    } else {
      result = { runs, find: message.kind === 'find' ? message.report : undefined };
    }
  });
  return new Promise((resolve, reject) => {
    child.on('error', reject);
    child.on('close', (code, signal) => {
      clearTimeout(timer);
      const how = timedOut
        ? `a series of inputs took longer than ${kSeriesTimeout_ms / 1000} s`
        : `the process ended early with ${signal ?? `exit code ${code}`}`;
      const again = `repeat with: npm run fuzz -- --seed ${seed} ${name}`;
      resolve(result ?? { runs, find: `${how}; ${again}\n${errorText}` });
    });
  });
}
