import { join } from 'node:path';
import { readFile } from 'node:fs/promises';
import type { Command } from 'commander';
import { parse } from 'smol-toml';
import { z } from 'zod';
import { GrabberError, causedError, describeError } from '../util/errors.js';
import { writeFileAtomically } from '../util/files.js';
import type { CliContext } from './context.js';
import { readStore, storeOption, type StoreOption } from './with-store.js';
import type { StoreRecord } from '../model/store.js';
import { printableLine } from '../util/text.js';

type AttributionOptions = StoreOption & { readonly output?: string };

export function addAttributionCommand(program: Command, context: CliContext): void {
  program
    .command('attribution')
    .description('credits for pictures of this data: source, licence, attribution and years')
    .addOption(storeOption())
    .option('--output <file>', 'write to this file (default: standard output)')
    .action((options: AttributionOptions) => attributionCommand(options, context));
}

async function attributionCommand(options: AttributionOptions, context: CliContext): Promise<void> {
  const { output, signal } = context;
  const sources = await context.sources();
  const addresses = await loadLicenceAddresses(
    join(context.configFolder(), 'licences.toml'),
    signal,
  );
  const titles = new Map([...sources.values()].map(({ id, title }) => [id, title]));
  const text = await readStore(options.store, signal, (store) =>
    attributionText(
      store.squares.list({ usable: true }),
      store.orthophotos.list({ usable: true }),
      { titles, addresses },
    ),
  );
  if (options.output === undefined) return output.out(text);
  try {
    await writeFileAtomically(options.output, text, signal);
  } catch (error) {
    signal.throwIfAborted();
    const attempt = `write attribution ${options.output}`;
    throw causedError('STORE_IO', attempt, error, 'a file that can be written');
  }
}

export type AttributionNames = {
  /** By source id; sources of the user's own have none. */
  readonly titles: ReadonlyMap<string, string>;
  /** By licence. */
  readonly addresses: ReadonlyMap<string, string>;
};

type Group = {
  readonly first: StoreRecord;
  readonly what: string;
  count: number;
  years: Set<number>;
};

/**
 * What must be said of the data when pictures of it are shown.
 * @param squares, orthophotos the usable ones
 */
export function attributionText(
  squares: readonly StoreRecord[],
  orthophotos: readonly StoreRecord[],
  names: AttributionNames,
): string {
  const groups = [...grouped(squares, 'LiDAR squares'), ...grouped(orthophotos, 'orthophotos')];
  if (groups.length === 0) return 'The store holds no data yet.\n';
  return groups.map((group) => groupText(group, names)).join('\n');
}

/** One text per source; several where its terms have changed over time. */
function grouped(records: readonly StoreRecord[], what: string): Group[] {
  const groups = new Map<string, Group>();
  for (const record of records) {
    const id = JSON.stringify([record.key.source, record.licence, record.attribution]);
    const group = groups.get(id) ?? { first: record, what, count: 0, years: new Set() };
    groups.set(id, group);
    ++group.count;
    const year = /^\d{4}/.exec(record.published ?? '')?.[0];
    if (year !== undefined) group.years.add(Number(year));
  }
  return [...groups.values()];
}

function groupText(
  { first, what, count, years }: Group,
  { titles, addresses }: AttributionNames,
): string {
  const { key, licence, attribution } = first;
  const title = titles.get(key.source);
  const address = licence === null ? undefined : addresses.get(licence);
  const lines = [
    title === undefined ? key.source : `${title} (${key.source})`,
    `  data:        ${count} ${what}`,
    `  years:       ${yearsText(years)}`,
    `  licence:     ${licence ?? 'not recorded'}`,
    ...(address === undefined ? [] : [`               ${address}`]),
    `  attribution: ${attribution ?? 'not recorded'}`,
  ];
  // Each of them is the text of a source or of a store, which must not look like further ones.
  return `${lines.map(printableLine).join('\n')}\n`;
}

function yearsText(years: ReadonlySet<number>): string {
  if (years.size === 0) return 'not recorded';
  const low = Math.min(...years);
  const high = Math.max(...years);
  return low === high ? String(low) : `${low} to ${high}`;
}

const licencesSchema = z.strictObject({
  licence: z.array(
    z.strictObject({ name: z.string().min(1).max(200), url: z.url({ protocol: /^https?$/ }) }),
  ),
});

/**
 * Where the text of a licence stands, by its name as the sources have it.
 * @param path of licences.toml
 */
export async function loadLicenceAddresses(
  path: string,
  signal: AbortSignal,
): Promise<ReadonlyMap<string, string>> {
  try {
    const { licence } = licencesSchema.parse(
      parse(await readFile(path, { encoding: 'utf8', signal })),
    );
    return new Map(licence.map(({ name, url }) => [name, url]));
  } catch (error) {
    signal.throwIfAborted();
    const why =
      error instanceof z.ZodError
        ? (error.issues[0]?.message ?? 'not valid')
        : describeError(error);
    throw new GrabberError(
      'CONFIG',
      `read licences ${path}: ${why}; allowed: [[licence]] tables with name and url`,
      { cause: error },
    );
  }
}
