import { spawn, type ChildProcess } from 'node:child_process';
import { join } from 'node:path';
import { run } from '../../../grabber/src/cli/program.js';
import { readPackageInfo } from '../../../grabber/src/util/package-info.js';
import { kNever } from './store-fixture.js';

const kMain = join(readPackageInfo().root, 'dist', 'main.js');

export type CliResult = {
  readonly code: number | null;
  readonly out: string;
  readonly err: string;
};

/** The words of a command line: it is split at its blanks, and values stay whole. */
export function words(texts: TemplateStringsArray, ...values: readonly string[]): string[] {
  const line = texts.reduce((all, text, index) => `${all}\0${index - 1}\0${text}`);
  const split = line.trim().split(/\s+/);
  return split.map((word) => word.replace(/\0(\d+)\0/g, (_, index) => values[Number(index)] ?? ''));
}

/** Runs one command in this process: a start of the program takes longer than most commands. */
export async function cli(args: readonly string[]): Promise<CliResult> {
  const shown = { out: '', err: '' };
  const streams = {
    out: (text: string) => void (shown.out += text),
    err: (text: string) => void (shown.err += text),
  };
  const code = await run(args, streams, kNever);
  return { code, ...shown };
}

/** Runs the built program. `onStart` may signal the child. */
export function program(
  args: readonly string[],
  onStart: (child: ChildProcess) => void = () => undefined,
): Promise<CliResult> {
  return new Promise((resolve, reject) => {
    const child = spawn(process.execPath, [kMain, ...args], { stdio: ['ignore', 'pipe', 'pipe'] });
    let out = '';
    let err = '';
    child.stdout.setEncoding('utf8').on('data', (text: string) => (out += text));
    child.stderr.setEncoding('utf8').on('data', (text: string) => (err += text));
    child.on('error', reject);
    child.on('close', (code) => resolve({ code, out, err }));
    onStart(child);
  });
}
