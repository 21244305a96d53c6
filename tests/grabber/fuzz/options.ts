import { parseArgs } from 'node:util';

export const kUsage = `Usage: npm run fuzz -- [--seconds N] [--jobs N] [--seed N] [NAME...]

  NAME         a fuzz target; all targets when none is named
  --seconds N  how long each target runs, 1 to 999999 [3]
  --jobs N     how many targets run at a time, each in a process of its own, 1 to 64 [1]
  --seed N     seed of the first series of inputs, 1 to 999999999 [taken from the clock]
`;

/** The command line cannot be used; the message is one line. */
export class FuzzUsageError extends Error {}

export type FuzzOptions = {
  /** How long each target runs. */
  readonly seconds: number;
  /** How many targets run at a time. */
  readonly jobs: number;
  readonly seed: number;
  /** In the order of the targets' table, each once. */
  readonly names: readonly string[];
};

const kNumbers = {
  seconds: { max: 999_999, initial: () => 3 },
  jobs: { max: 64, initial: () => 1 },
  seed: { max: 999_999_999, initial: () => 1 + (Date.now() % 999_999_999) },
} as const;

/**
 * @param words the command line without the program
 * @param targets names of all fuzz targets
 * @throws FuzzUsageError for an unknown option or name, and for a number out of its range
 */
export function parseFuzzOptions(
  words: readonly string[],
  targets: readonly string[],
): FuzzOptions {
  const { values, positionals } = splitWords(words);
  const unknown = positionals.find((name) => !targets.includes(name));
  if (unknown !== undefined) {
    throw new FuzzUsageError(`no target is called "${unknown}"; allowed: ${targets.join(', ')}`);
  }
  return {
    seconds: wholeNumber('seconds', values.seconds),
    jobs: wholeNumber('jobs', values.jobs),
    seed: wholeNumber('seed', values.seed),
    names: targets.filter((name) => positionals.length === 0 || positionals.includes(name)),
  };
}

type Words = {
  readonly values: { readonly seconds?: string; readonly jobs?: string; readonly seed?: string };
  readonly positionals: readonly string[];
};

function splitWords(words: readonly string[]): Words {
  try {
    return parseArgs({
      args: [...words],
      allowPositionals: true,
      options: {
        seconds: { type: 'string' },
        jobs: { type: 'string' },
        seed: { type: 'string' },
      },
    });
  } catch (error) {
    throw new FuzzUsageError(error instanceof Error ? error.message : String(error));
  }
}

function wholeNumber(name: keyof typeof kNumbers, text: string | undefined): number {
  const { max, initial } = kNumbers[name];
  if (text === undefined) return initial();
  const value = /^[1-9]\d{0,8}$/.test(text) ? Number(text) : 0;
  if (value < 1 || value > max) {
    throw new FuzzUsageError(`--${name} is "${text}"; allowed: 1 to ${max}`);
  }
  return value;
}
