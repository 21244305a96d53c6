import { spawn, type ChildProcess } from 'node:child_process';
import { join } from 'node:path';
import { mkdir, writeFile, chmod } from 'node:fs/promises';
import type { TestContext } from 'node:test';
import { run } from '../../../grabber/src/cli/program.js';
import { readPackageInfo } from '../../../grabber/src/util/package-info.js';
import { kNever, temporaryFolder } from './store-fixture.js';

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

/**
 * A source "here" of LiDAR squares, served by this machine.
 * @param access lines of its [access]
 */
export function sourceHere(access: string, missingStatus = 403): string {
  return `id = "here"
title = "Here"
licence = "CC BY 4.0"
attribution = "Us"
crs = "EPSG:3794"
square_m = 1000
extent_m = [400000, 50000, 500000, 150000]
class_table = "asprs"
max_concurrent = 2
missing_status = [${missingStatus}]
allow_private_addresses = true

[access]
${access}
`;
}

/** Squares at an address each. */
export function templateAccess(base: string): string {
  return `kind = "template"\nurls = ["${base}/TM_{E}_{N}.laz"]`;
}

/** A configuration with that source alone. */
export async function configFolder(t: TestContext, access: string): Promise<string> {
  const folder = await temporaryFolder(t);
  await mkdir(join(folder, 'sources'));
  await writeFile(join(folder, 'sources', 'here.toml'), sourceHere(access));
  return folder;
}

/**
 * Writes a program of node's language.
 * @return its path; words follow in process.argv from 2 on
 */
export async function script(folder: string, name: string, body: string): Promise<string> {
  const path = join(folder, `${name}.cjs`);
  await writeFile(path, `#!${process.execPath}\n${body}\n`);
  await chmod(path, 0o755);
  return path;
}
