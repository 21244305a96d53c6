import { spawn, type ChildProcess } from 'node:child_process';
import { existsSync } from 'node:fs';
import { basename, join } from 'node:path';
import { lstat, readdir } from 'node:fs/promises';
import { GrabberError, oneLine } from '../util/errors.js';

/** Limits for an external program, which reads untrusted files. */
export type CommandLimits = {
  readonly time_limit_s: number;
  /** Limit for all files in its folder together, and for each file that it writes anywhere. */
  readonly disk_bytes: number;
  /** Address space; undefined = no limit. */
  readonly memory_bytes?: number;
};

export type Command = {
  /** In messages, such as "convert square 462_101". */
  readonly what: string;
  /**
   * The program and its words; `{input}` and the like stand for `values`, in a word or as one.
   * Never read by a shell.
   */
  readonly argv: readonly string[];
  /** Absolute paths; undefined = the words stand for themselves, braces and all. */
  readonly values?: Readonly<Record<string, string>>;
  /** Its own folder, which it starts in and which is its home. */
  readonly folder: string;
  readonly limits: CommandLimits;
  /** Added to a minimal environment. */
  readonly environment?: Readonly<Record<string, string>>;
  /** For its standard input; none = an empty one. */
  readonly input?: string | undefined;
};

export type CommandOutput = { readonly out: string; readonly err: string };

const kPlaceholder = /\{([a-z]+)\}/g;
const kMaxOutput = 4 << 20;
const kMaxErrorText = 4000;
const kPipeTimeout_ms = 2000;
const kPrlimit = '/usr/bin/prlimit';

/** @throws GrabberError CONFIG for a placeholder without a value */
export function fillArguments(
  argv: readonly string[],
  values: Readonly<Record<string, string>>,
): string[] {
  return argv.map((word) =>
    word.replace(kPlaceholder, (whole, name: string) => {
      const value = values[name];
      if (value !== undefined) return value;
      const allowed = Object.keys(values).map((one) => `{${one}}`);
      throw new GrabberError(
        'CONFIG',
        `fill command word "${word}": ${whole}; allowed: ${allowed.join(' ') || 'none'}`,
      );
    }),
  );
}

/**
 * Runs a program to its end, without a shell, in a process group of its own that is killed whole:
 * when it has taken too long, filled its folder, or the signal aborts, and also after its end, so
 * that nothing it started lives on.
 * @return what it wrote to standard output (at most 4 MiB) and the end of its standard error
 * @throws GrabberError COMMAND when it could not start or ended with anything but 0, or the
 *   signal's reason
 */
export async function runCommand(command: Command, signal: AbortSignal): Promise<CommandOutput> {
  signal.throwIfAborted();
  const child = start(command);
  const text = { out: '', err: '' };
  const limit_s = command.limits.time_limit_s;
  return await new Promise<CommandOutput>((resolve, reject) => {
    let reason: string | undefined;
    const stop = (why: string): void => {
      reason ??= why;
      killGroup(child);
    };
    collect(child, text, stop);
    const timer = setTimeout(() => stop(`it ran longer than ${limit_s} s`), limit_s * 1000);
    const unwatch = watchFolder(command.folder, command.limits.disk_bytes, stop);
    const onAbort = (): void => killGroup(child);
    signal.addEventListener('abort', onAbort, { once: true });
    let ended = false;
    const end = (settle: () => void): void => {
      if (ended) return;
      ended = true;
      clearTimeout(timer);
      unwatch();
      signal.removeEventListener('abort', onAbort);
      killGroup(child);
      settle();
    };
    const settle = (code: number | null, killedBy: NodeJS.Signals | null): void =>
      end(() => {
        if (signal.aborted) return reject(signal.reason as Error);
        if (reason === undefined && code === 0) return resolve(text);
        reject(failure(command, reason ?? howItEnded(code, killedBy), text.err));
      });
    child.once('error', (error) =>
      end(() => reject(failure(command, `could not start: ${error.message}`, '', error))),
    );
    child.once('close', settle);
    // A process that the program started may hold the pipes open. It is killed with the group,
    // unless it has left the group.
    child.once('exit', (code, killedBy) => {
      killGroup(child);
      setTimeout(() => settle(code, killedBy), kPipeTimeout_ms).unref();
    });
  });
}

/** @throws GrabberError CONFIG for an empty command, or a placeholder without a value */
function start({ what, argv, values, folder, limits, ...rest }: Command): ChildProcess {
  const filled = values === undefined ? [...argv] : fillArguments(argv, values);
  const [program, ...words] = withLimits(filled, limits);
  if (program === undefined) {
    throw new GrabberError(
      'CONFIG',
      `${what}: the command is empty; allowed: a program and its words`,
    );
  }
  const child = spawn(program, words, {
    cwd: folder,
    env: { ...programEnvironment(folder), ...rest.environment },
    stdio: ['pipe', 'pipe', 'pipe'],
    detached: true,
  });
  // A program that does not read its input closes it, which is no error.
  child.stdin.on('error', () => undefined);
  child.stdin.end(rest.input ?? '');
  return child;
}

function howItEnded(code: number | null, killedBy: NodeJS.Signals | null): string {
  return code === null ? `was ended by ${killedBy ?? 'a signal'}` : `ended with exit code ${code}`;
}

function withLimits(words: string[], limits: CommandLimits): string[] {
  if (!existsSync(kPrlimit)) return words;
  const memory = limits.memory_bytes === undefined ? [] : [`--as=${limits.memory_bytes}`];
  return [kPrlimit, `--fsize=${limits.disk_bytes}`, '--core=0', ...memory, '--', ...words];
}

function collect(
  child: ChildProcess,
  text: { out: string; err: string },
  stop: (why: string) => void,
): void {
  child.stdout?.setEncoding('utf8').on('data', (part: string) => {
    text.out += part;
    if (text.out.length > kMaxOutput) {
      stop(`it wrote more than ${kMaxOutput} characters to standard output`);
    }
  });
  child.stderr?.setEncoding('utf8').on('data', (part: string) => {
    text.err = (text.err + part).slice(-kMaxErrorText);
  });
}

/** Kills the process group of a program. The group keeps its number while any process is in it. */
function killGroup(child: ChildProcess): void {
  if (child.pid === undefined) return;
  try {
    process.kill(-child.pid, 'SIGKILL');
  } catch {
    // All of them have ended.
  }
}

function failure(command: Command, how: string, err: string, cause?: unknown): GrabberError {
  const said = lastLines(err);
  const program = basename(command.argv[0] ?? '');
  return new GrabberError(
    'COMMAND',
    `${command.what}: ${program} ${how}${said === '' ? '' : `: ${said}`}; allowed: exit ` +
      `code 0 within ${command.limits.time_limit_s} s and ${command.limits.disk_bytes} bytes ` +
      'of disk',
    { cause },
  );
}

function lastLines(text: string): string {
  const lines = text.split('\n').filter((line) => line.trim() !== '');
  return oneLine(lines.slice(-3).join(' | ')).slice(-600);
}

const kPollInterval_ms = 250;

/**
 * Sums the bytes of all files below `folder`. Links are not followed, and files that vanish
 * meanwhile count as 0.
 */
export async function folderBytes(folder: string): Promise<number> {
  let bytes = 0;
  for (const entry of await readdir(folder, { withFileTypes: true }).catch(() => [])) {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) bytes += await folderBytes(path);
    else {
      bytes += await lstat(path).then(
        (found) => found.size,
        () => 0,
      );
    }
  }
  return bytes;
}

/**
 * Calls `stop` once when the folder holds more than `max_bytes`.
 * @return ends the watch
 */
export function watchFolder(
  folder: string,
  max_bytes: number,
  stop: (why: string) => void,
): () => void {
  let looking = false;
  const timer = setInterval(() => {
    if (looking) return;
    looking = true;
    void folderBytes(folder).then((bytes) => {
      looking = false;
      if (bytes > max_bytes) stop(`it filled its folder with ${bytes} bytes`);
    });
  }, kPollInterval_ms);
  return () => clearInterval(timer);
}

/** Variables with the data folders of GDAL's programs, for installations that were moved. */
const kData = ['GDAL_DATA', 'PROJ_DATA', 'PROJ_LIB'] as const;

/**
 * The environment of external programs, which read untrusted files: no tokens, proxies or library
 * paths are passed on.
 * @param home a folder in which the program may write
 */
export function programEnvironment(home: string): Record<string, string> {
  const path = process.env['PATH'] ?? '/usr/local/bin:/usr/bin:/bin';
  const data = kData.flatMap((name) =>
    process.env[name] === undefined ? [] : [[name, process.env[name]] as const],
  );
  return {
    PATH: path,
    HOME: home,
    TMPDIR: home,
    LANG: 'C.UTF-8',
    LC_ALL: 'C.UTF-8',
    ...Object.fromEntries(data),
  };
}
