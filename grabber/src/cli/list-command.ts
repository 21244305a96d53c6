import { join } from 'node:path';
import type { Command } from 'commander';
import { select, type SelectionOptions } from '../select/selection.js';
import { listHosts, listVariables, type Source } from '../sources/source.js';
import { type CliContext, formatTable } from './context.js';
import { toAccess, openClient } from './fill-store.js';
import { addRequestOptions, monitorCatalogue, type RequestOptions } from './run-options.js';
import { addSelectionOptions } from './options.js';
import { measureExtent, loadAreas } from '../select/areas.js';

type ListOptions = SelectionOptions & RequestOptions & { json?: boolean };

export function addListCommand(program: Command, context: CliContext): void {
  const command = addSelectionOptions(
    program
      .command('list')
      .description(
        'print the squares of some ground and their addresses, as their catalogue has them',
      ),
    context,
  );
  addRequestOptions(command)
    .option('--json', 'print one JSON object a line')
    .action((options: ListOptions) => listCommand(options, context));
}

export function addSourcesCommand(program: Command, context: CliContext): void {
  program
    .command('sources')
    .description('list the sources')
    .option('--json', 'print JSON')
    .action(async ({ json }: { json?: boolean }) =>
      sourcesCommand(await context.sources(), json ?? false, context),
    );
}

/**
 * Prints the squares of a region. Addresses that follow a rule are computed, and others come from
 * the catalogue; "?" marks an address that only a fetch determines.
 */
async function listCommand(options: ListOptions, context: CliContext): Promise<void> {
  const { output, signal } = context;
  const http = openClient(context, options);
  try {
    const monitor = monitorCatalogue(options, output);
    const selection = await select(options, await context.sources(), http, signal, monitor);
    const { source, profile, catalogue, region } = selection;
    http.permit(toAccess(profile));
    for await (const square of catalogue.find(region, signal)) {
      if (options.json === true) output.outLine(JSON.stringify({ source, ...square }));
      else output.outLine(`${square.name}\t${square.urls[0] ?? '?'}`);
    }
    context.exit(monitor.code());
  } finally {
    await http.close();
  }
}

function sourcesCommand(
  sources: ReadonlyMap<string, Source>,
  json: boolean,
  { output }: CliContext,
): void {
  const all = [...sources.values()];
  if (json) {
    const shown = all.map((source) => ({ ...source, hosts: listHosts(source) }));
    return output.out(`${JSON.stringify(shown, undefined, 2)}\n`);
  }
  const rows = all.map((source) => [
    source.id,
    source.crs,
    source.square_m === undefined ? '-' : `${source.square_m} m`,
    source.class_table,
    source.access.kind,
    String(source.max_concurrent),
    listNeeds(source),
    source.licence,
    source.title,
  ]);
  const title = 'id,crs,square,classes,access,at once,needs,licence,title';
  output.out(formatTable(title.split(','), rows));
}

/** Variables without a value in the configuration: the user has to give one. */
function listNeeds(source: Source): string {
  const open = Object.entries(listVariables(source)).filter(
    ([, { value, values }]) => value === undefined && values === undefined,
  );
  return open.map(([name]) => name).join(' ') || '-';
}

export function addAreasCommand(program: Command, context: CliContext): void {
  program
    .command('areas')
    .description('list the areas for --area')
    .option('--json', 'print JSON')
    .action(async ({ json }: { json?: boolean }) => {
      const areas = await loadAreas(join(context.configFolder(), 'areas'), context.signal);
      if (json === true) return context.output.out(`${JSON.stringify(areas, undefined, 2)}\n`);
      const rows = areas.map((area) => {
        const { lon, lat, width_m, height_m } = measureExtent(area);
        return [
          area.name,
          `${lat.toFixed(3)} N`,
          `${lon.toFixed(3)} E`,
          `${km(width_m)} x ${km(height_m)} km`,
          area.title,
        ];
      });
      context.output.out(formatTable(['name', 'latitude', 'longitude', 'size', 'title'], rows));
    });
}

function km(metres: number): string {
  return (metres / 1000).toFixed(1);
}
