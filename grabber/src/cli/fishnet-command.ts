import type { Command } from 'commander';
import { kStates, type CatalogueSquare, type State, type Region } from '../model/store.js';
import { givenVariables } from '../select/ad-hoc.js';
import { readFishnet } from '../select/fishnet-file.js';
import { kAll, chosenRegion } from '../select/region.js';
import {
  findSource,
  toGridInfo,
  toRecordFields,
  type SelectionOptions,
} from '../select/selection.js';
import { usage } from '../util/errors.js';
import { isInRegion } from '../sources/catalogue/listing.js';
import { openCatalogue } from '../sources/catalogue/open-catalogue.js';
import { toProfile, type Source } from '../sources/source.js';
import { type CliContext, formatTable } from './context.js';
import { toAccess, openClient } from './fill-store.js';
import { parseNameList, addRegionOptions, addVariableOptions } from './options.js';
import { addRequestOptions, monitorCatalogue, type RequestOptions } from './run-options.js';
import { makeStore, readStore, storeOption } from './with-store.js';

/** A whole country is more than one may fetch in a run. */
const kMaxFishnet = 1_000_000;

type ImportOptions = Omit<SelectionOptions, 'from'> &
  RequestOptions & {
    source: string;
    store?: string;
    from?: string;
    nameField?: string;
    blockField?: string;
    xField?: string;
    yField?: string;
    dryRun?: boolean;
  };
type ListOptions = { store: string; source?: string; state?: string[]; json?: boolean };

export function addFishnetCommand(program: Command, context: CliContext): void {
  const fishnet = program.command('fishnet').description('the squares in the database of a store');
  const command = fishnet
    .command('import')
    .description("learn squares from a fishnet file, or from the source's catalogue")
    .requiredOption('--source <id>', 'source whose squares they are')
    .option('--store <folder>', 'store to write to; made when it is not there')
    .option(
      '--from <file>',
      'Shapefile, bare DBF, GeoJSON or GeoPackage with a row per square, instead of the catalogue',
    )
    .option('--name-field <column>', 'column of the name, 462_101 or TM_462_101 (default: NAME)')
    .option(
      '--block-field <column>',
      'column of the survey block (default: BLOK, where there is one)',
    )
    .option(
      '--x-field <column>',
      'column of the centre, east (default: CENTERX, where there is one)',
    )
    .option(
      '--y-field <column>',
      'column of the centre, north (default: CENTERY, where there is one)',
    )
    .option('--dry-run', 'count, and write nothing');
  addVariableOptions(addRegionOptions(addRequestOptions(command), context)).action(
    (options: ImportOptions) => importCommand(options, context),
  );
  fishnet
    .command('list')
    .description('print the squares in the database of a store')
    .addOption(storeOption())
    .option('--source <id>', 'of this source only')
    .option('--state <list>', `in these states only: ${kStates.join(', ')}`, parseNameList)
    .option('--json', 'print one JSON object a line')
    .action((options: ListOptions) => listCommand(options, context));
}

async function importCommand(options: ImportOptions, context: CliContext): Promise<void> {
  const { output, signal } = context;
  const { from, store: root, ...choice } = options;
  if (root === undefined && options.dryRun !== true) {
    throw usage('import fishnet: no store; allowed: --store FOLDER, or --dry-run');
  }
  const source = findSource({ source: options.source }, await context.sources());
  if (source === undefined) throw usage('import fishnet: no source; allowed: --source ID');
  const region = (await chosenRegion(choice, toGridInfo(source), signal)) ?? kAll;
  const squares =
    from === undefined
      ? await fromCatalogue(source, region, options, context)
      : await fromFile(from, source, region, options, context);
  const blocks = new Set(squares.map((square) => square.block).filter((block) => block !== null));
  const open = squares.filter((square) => square.urls.length === 0).length;
  const counted =
    `${squares.length} squares of ${source.id}, ${blocks.size} blocks, ${open} without an ` +
    'address yet';
  if (options.dryRun === true || root === undefined) {
    output.outLine(`${counted}; nothing written`);
    return;
  }
  const { source: id, grid, gridCrs, terms } = toRecordFields(source);
  const { added, changed } = await makeStore(root, signal, async (store) =>
    store.squares.learn(id, grid, gridCrs, terms, squares),
  );
  output.outLine(`${counted}: ${added} added, ${changed} changed`);
}

async function fromFile(
  file: string,
  source: Source,
  region: Region,
  options: ImportOptions,
  { signal }: CliContext,
): Promise<CatalogueSquare[]> {
  const { nameField: name, blockField: block, xField: x, yField: y } = options;
  const fields = { name, block, x, y };
  const all = await readFishnet(file, source, fields, givenVariables(options), signal);
  return all.filter((square) => isInRegion(square, region));
}

async function fromCatalogue(
  source: Source,
  region: Region,
  options: ImportOptions,
  context: CliContext,
): Promise<CatalogueSquare[]> {
  const { output, signal, exit } = context;
  const fields = {
    '--name-field': options.nameField,
    '--block-field': options.blockField,
    '--x-field': options.xField,
    '--y-field': options.yField,
  };
  const unused = Object.entries(fields).find(([, value]) => value !== undefined);
  if (unused !== undefined) {
    throw usage(`import fishnet: ${unused[0]} without --from; allowed: only with a file`);
  }
  const http = openClient(context, options, toAccess(toProfile(source)));
  const monitor = monitorCatalogue(options, output);
  try {
    const catalogue = openCatalogue(source, http, {
      variables: givenVariables(options),
      ...monitor,
      maxSquares: kMaxFishnet,
      limits: { items: kMaxFishnet, pages: 20_000 },
    });
    const squares: CatalogueSquare[] = [];
    for await (const square of catalogue.find(region, signal)) squares.push(square);
    exit(monitor.code());
    return squares;
  } finally {
    await http.close();
  }
}

async function listCommand(options: ListOptions, { output, signal }: CliContext): Promise<void> {
  const states = options.state?.map((text): State => {
    const state = kStates.find((one) => one === text);
    if (state === undefined) {
      throw usage(`list fishnet: state "${text}"; allowed: ${kStates.join(', ')}`);
    }
    return state;
  });
  await readStore(options.store, signal, (store) => {
    const records = store.squares.list({ source: options.source, states });
    if (options.json === true) {
      for (const record of records) output.outLine(JSON.stringify(record));
      return;
    }
    const rows = records.map(({ key, state, block, urls }) => [
      key.source,
      key.name,
      state,
      block ?? '-',
      urls[0] ?? '?',
    ]);
    output.out(formatTable(['source', 'square', 'state', 'block', 'address'], rows));
  });
}
