import type { Command } from 'commander';
import { createHttpClient, kNoAccess } from '../fetch/http-client.js';
import { select, type SelectionOptions } from '../select/selection.js';
import { listHosts } from '../sources/hosts.js';
import { listVariables, type Source } from '../sources/source.js';
import { userAgent } from '../util/package-info.js';
import type { CliContext } from './context.js';
import { toAccess } from './lidar-job.js';
import { formatTable } from './output.js';
import { addRequestOptions, monitorCatalogue, type RequestOptions } from './run-options.js';
import { addSelectionOptions } from './selection.js';

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
  const http = createHttpClient({
    userAgent: userAgent(context.info),
    timeout_ms: options.timeoutS * 1000,
    access: kNoAccess,
  });
  try {
    const monitor = monitorCatalogue(options, output);
    const { source, profile, catalogue, region } = await select(
      options,
      await context.sources(),
      http,
      signal,
      monitor,
    );
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
    output.out(
      `${JSON.stringify(
        all.map((source) => ({ ...source, hosts: listHosts(source) })),
        undefined,
        2,
      )}\n`,
    );
    return;
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
  output.out(
    formatTable(
      ['id', 'crs', 'square', 'classes', 'access', 'at once', 'needs', 'licence', 'title'],
      rows,
    ),
  );
}

/** Variables without a value in the configuration: the user has to give one. */
function listNeeds(source: Source): string {
  const open = Object.entries(listVariables(source)).filter(
    ([, { value, values }]) => value === undefined && values === undefined,
  );
  return open.map(([name]) => name).join(' ') || '-';
}
