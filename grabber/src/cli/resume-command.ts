import type { Command } from 'commander';
import type { FetchJob } from '../fetch/run-jobs.js';
import type { SourceClient } from '../fetch/http-client.js';
import type { StoreRecord, Store } from '../model/store.js';
import type { Reporter } from '../progress/reporter.js';
import { openCatalogue } from '../sources/catalogue/open-catalogue.js';
import { toProfile, type Source } from '../sources/source.js';
import { type CliContext, kExit, chooseWorse } from './context.js';
import { conversionFor, fillStore, toAccess, lidarJob, openClient } from './fill-store.js';
import {
  addRunOptions,
  monitorCatalogue,
  chooseReporter,
  chooseStore,
  type RunOptions,
} from './run-options.js';
import { checkSource, writeStore } from './with-store.js';

export type ResumeOptions = RunOptions & { source?: string };

const kAdHoc =
  'its source has no configuration; allowed: run fetch again with the options of the first time';
const kFromFolder =
  'they came from a folder; allowed: run fetch --from again with the options of the first time';

export function addResumeCommand(program: Command, context: CliContext): void {
  const about =
    'finish the squares that earlier runs have begun, and report unfinished orthophotos';
  addRunOptions(program.command('resume').description(about), 'store to continue')
    .option('--source <id>', 'only the squares of this source')
    .action(async (options: ResumeOptions) => context.exit(await resumeCommand(options, context)));
}

/**
 * Continues everything that is unfinished in a store.
 * @return the exit code
 */
async function resumeCommand(options: ResumeOptions, context: CliContext): Promise<number> {
  const sources = await context.sources();
  const reporter = chooseReporter(options, context.output);
  const clients: SourceClient[] = [];
  const makeClient = (source: Source): SourceClient => {
    const client = openClient(context, options, toAccess(toProfile(source)));
    clients.push(client);
    return client;
  };
  const continueIn = async (store: Store): Promise<number> => {
    checkSource(store, options.source);
    const { jobs, skipped } = makeJobs(store, sources, makeClient, options, reporter, context);
    const excluded = { kept: 0, known_missing: 0, skipped };
    const code = await fillStore(jobs, store, excluded, options, reporter, context.signal);
    const left = reportOrthophotos(store, options.source, reporter);
    return left > 0 ? chooseWorse(code, kExit.holes) : code;
  };
  try {
    return await writeStore(chooseStore(options), context.signal, continueIn);
  } finally {
    reporter.close();
    await Promise.all(clients.map((client) => client.close()));
  }
}

/**
 * Reports unfinished orthophotos, which another command makes, with options that the store does not
 * record.
 * @return how many are unfinished
 */
function reportOrthophotos(store: Store, grid: string | undefined, reporter: Reporter): number {
  const records = store.orthophotos.unfinished({ grid });
  const groups = new Map<string, { source: string; grid: string; count: number }>();
  for (const { key } of records) {
    const id = `${key.source}/${key.grid}`;
    const group = groups.get(id) ?? { source: key.source, grid: key.grid, count: 0 };
    groups.set(id, group);
    ++group.count;
  }
  for (const { source, grid, count } of groups.values()) {
    reporter.orthophotosLeft(source, grid, count);
  }
  return records.length;
}

/**
 * Makes one job for each source. The limits of its hosts come from the configuration, not from the
 * store.
 */
function makeJobs(
  store: Store,
  sources: ReadonlyMap<string, Source>,
  makeClient: (source: Source) => SourceClient,
  options: ResumeOptions,
  reporter: Reporter,
  context: CliContext,
): { jobs: FetchJob[]; skipped: number } {
  const convert = conversionFor(context);
  const jobs: FetchJob[] = [];
  let skipped = 0;
  const skip = (id: string, records: readonly StoreRecord[], why: string): void => {
    if (records.length > 0) reporter.skipped(id, records.length, why);
    skipped += records.length;
  };
  for (const [id, records] of bySource(store, options.source)) {
    const source = sources.get(id);
    if (source === undefined) {
      skip(id, records, kAdHoc);
      continue;
    }
    const local = records.filter(({ urls }) => urls.some((url) => url.startsWith('file:')));
    skip(id, local, kFromFolder);
    const http = makeClient(source);
    const rest = records.filter((record) => !local.includes(record));
    const catalogue = openCatalogue(source, http, monitorCatalogue(options, context.output));
    const profile = toProfile(source);
    jobs.push(lidarJob(rest, profile, catalogue, store, http, false, options, convert));
  }
  return { jobs, skipped };
}

function bySource(store: Store, only: string | undefined): Map<string, StoreRecord[]> {
  const groups = new Map<string, StoreRecord[]>();
  for (const record of store.squares.unfinished({ source: only })) {
    const group = groups.get(record.key.source) ?? [];
    group.push(record);
    groups.set(record.key.source, group);
  }
  return groups;
}
