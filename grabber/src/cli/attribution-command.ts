import { join } from 'node:path';
import type { Command } from 'commander';
import { attributionText } from '../report/attribution.js';
import { loadLicenceAddresses } from '../report/licences.js';
import { GrabberError, describeError } from '../util/errors.js';
import { writeFileAtomically } from '../util/files.js';
import type { CliContext } from './context.js';
import { readStore, storeOption, type StoreOption } from './with-store.js';

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
    throw new GrabberError(
      'STORE_IO',
      `write attribution ${options.output}: ${describeError(error)}; allowed: a file that ` +
        'can be written',
      { cause: error },
    );
  }
}
