import { readFileSync } from 'node:fs';
import { Session, type Profiler } from 'node:inspector';
import { fileURLToPath } from 'node:url';

/** Compiled sources of the grabber, below the folder of the tests. */
const kSources = /\/grabber\/src\/.*\.js$/;

/**
 * Counts the lines of the grabber's sources that this process runs after start(), as V8 sees them.
 * Lines of compiled sources: TypeScript keeps most as they are.
 */
export class Coverage {
  readonly #session = new Session();

  async start(): Promise<void> {
    this.#session.connect();
    await this.#ask('Profiler.enable');
    await this.#ask('Profiler.startPreciseCoverage', { callCount: false, detailed: true });
  }

  async lines(): Promise<number> {
    const { result } = (await this.#ask('Profiler.takePreciseCoverage')) as {
      result: Profiler.ScriptCoverage[];
    };
    let lines = 0;
    for (const { url, functions } of result) {
      if (!url.startsWith('file:') || !kSources.test(url)) continue;
      lines += countLines(readFileSync(fileURLToPath(url), 'utf8'), functions);
    }
    return lines;
  }

  #ask(method: string, parameters: object = {}): Promise<object> {
    return new Promise((resolve, reject) => {
      this.#session.post(method, parameters, (error, answer?: object) => {
        if (error === null) resolve(answer ?? {});
        else reject(error);
      });
    });
  }
}

/** @returns the lines of a source on which something has run: functions and, inside, branches */
export function countLines(
  source: string,
  functions: readonly Profiler.FunctionCoverage[],
): number {
  const ran = new Uint8Array(source.length);
  // A range comes after the one that it lies in, and within it says otherwise.
  for (const { ranges } of functions) {
    for (const { startOffset, endOffset, count } of ranges) {
      ran.fill(count > 0 ? 1 : 0, startOffset, endOffset);
    }
  }
  let lines = 0;
  let start = 0;
  for (const line of source.split('\n')) {
    const at = start + line.search(/\S/);
    if (line.trim() !== '' && ran[at] === 1) lines += 1;
    start += line.length + 1;
  }
  return lines;
}
