import { spawn, type ChildProcess } from 'node:child_process';
import { join } from 'node:path';
import { readPackageInfo } from '../../../grabber/src/util/package-info.js';

const kMain = join(readPackageInfo().root, 'dist', 'main.js');

export type CliResult = {
  readonly code: number | null;
  readonly out: string;
  readonly err: string;
};

/** Runs the built program. `onStart` may signal the child. */
export function cli(
  args: readonly string[],
  onStart: (child: ChildProcess) => void = () => undefined,
  environment: Readonly<Record<string, string>> = {},
): Promise<CliResult> {
  return new Promise((resolve, reject) => {
    const child = spawn(process.execPath, [kMain, ...args], {
      stdio: ['ignore', 'pipe', 'pipe'],
      env: { ...process.env, ...environment },
    });
    let out = '';
    let err = '';
    child.stdout.setEncoding('utf8').on('data', (text: string) => (out += text));
    child.stderr.setEncoding('utf8').on('data', (text: string) => (err += text));
    child.on('error', reject);
    child.on('close', (code) => resolve({ code, out, err }));
    onStart(child);
  });
}
