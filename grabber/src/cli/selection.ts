import { InvalidArgumentError, Option, type Command } from 'commander';
import { profileOf, type SourceProfile } from '../sources/profile.js';
import type { Source } from '../sources/source.js';
import { parseSquare, squaresInBox, type BoundsM, type Square } from '../sources/square.js';
import { expandTemplate, placeholdersOf, templateProblem, type Variables } from '../sources/url-template.js';
import { GrabberError } from '../util/errors.js';
import { collectVariable, parseBox, parseNameList, parseSourceId, parseStatusList } from './option-parsers.js';

export type SelectionOptions = {
  source?: string;
  urlTemplate?: string;
  squares?: string[];
  bbox?: BoundsM;
  block?: string;
  set?: Variables;
  as?: string;
  crs?: string;
  licence?: string;
  attribution?: string;
  missingStatus?: number[];
};

/** Squares and their addresses. */
export type Selection = {
  readonly profile: SourceProfile;
  readonly squares: readonly Square[];
  urlOf(square: Square): string;
};

const kAdHocSquareM = 1000;
/** Becomes a file name in the store. */
const kPlainName = /^[A-Za-z0-9][A-Za-z0-9._-]{0,119}$/;

export function addSelectionOptions(command: Command): Command {
  return command
    .option('--source <id>', 'source to ask, one of those that "sources" lists')
    .option(
      '--squares <names>',
      'squares, E_N of the south-west corner in kilometres, separated by commas',
      parseNameList,
    )
    .option('--bbox <w,s,e,n>', "all squares that touch this box, metres in the source's CRS", parseBox)
    .option('--block <name>', 'short for --set block=<name>')
    .option('--set <name=value>', "value of a source's own placeholder; may be repeated", collectVariable)
    .option(
      '--url-template <url>',
      "address to use instead of the source's: {E} {N} km, {x} {y} m, {name}; {x:06} pads",
    )
    .option(
      '--as <id>',
      'without --source: folder name in the store (default: adhoc, or local with --from)',
      parseSourceId,
    )
    .option('--crs <code>', 'without --source: CRS to record, such as EPSG:3794', parseCrs)
    .option('--licence <text>', 'without --source: licence to record')
    .option('--attribution <text>', 'without --source: attribution to record')
    .addOption(
      new Option(
        '--missing-status <list>',
        'without --source: statuses that mean "no such square" (default: 404)',
      ).argParser(parseStatusList),
    );
}

function parseCrs(text: string): string {
  if (/^EPSG:\d{4,6}$/.test(text)) return text;
  throw new InvalidArgumentError('allowed: EPSG:<number>, such as EPSG:3794');
}

export function usage(message: string): GrabberError {
  return new GrabberError('USAGE', message);
}

/** @return undefined without --source */
export function findSource(options: SelectionOptions, sources: ReadonlyMap<string, Source>): Source | undefined {
  if (options.source === undefined) return undefined;
  const source = sources.get(options.source);
  if (source === undefined) {
    throw usage(
      `choose source: "${options.source}"; allowed: ${[...sources.keys()].join(', ') || 'none, the sources folder is empty'}`,
    );
  }
  const ownWords = {
    '--as': options.as,
    '--crs': options.crs,
    '--licence': options.licence,
    '--attribution': options.attribution,
    '--missing-status': options.missingStatus,
  };
  const clash = Object.entries(ownWords).find(([, value]) => value !== undefined);
  if (clash !== undefined)
    throw usage(`choose source: ${clash[0]} with --source ${source.id}; allowed: only without --source`);
  return source;
}

/** What to record of files whose source has no configuration. */
export function adHocProfile(options: SelectionOptions, id: string): SourceProfile {
  return {
    id: options.as ?? id,
    configured: false,
    crs: options.crs ?? null,
    class_table: null,
    licence: options.licence ?? null,
    attribution: options.attribution ?? null,
    square_m: kAdHocSquareM,
    missing_status: options.missingStatus ?? [404],
    max_concurrent: 4,
  };
}

/** The squares named by --squares or --bbox; undefined when neither is given. */
export function chosenSquares(
  options: SelectionOptions,
  source: Source | undefined,
  anyName: boolean,
): Square[] | undefined {
  if (options.squares !== undefined && options.bbox !== undefined) {
    throw usage('choose squares: --squares and --bbox; allowed: one of them');
  }
  const grid = { square_m: source?.square_m ?? kAdHocSquareM, extent_m: source?.extent_m };
  if (options.bbox !== undefined) return squaresInBox(options.bbox, grid);
  return options.squares?.map((name) => (anyName ? plainSquare(name) : parseSquare(name, grid)));
}

/** A square of which only the name matters. */
export function plainSquare(name: string): Square {
  if (kPlainName.test(name)) return { name, corner: undefined };
  throw usage(
    `read square name: "${name}"; allowed: letters, digits, ".", "_" and "-", at most 120, the first a letter or digit`,
  );
}

/** Squares to ask a web server for. */
export function remoteSelection(options: SelectionOptions, sources: ReadonlyMap<string, Source>): Selection {
  const source = findSource(options, sources);
  const template = options.urlTemplate ?? source?.url;
  if (template === undefined) throw usage('choose source: none given; allowed: --source ID or --url-template URL');
  const variables = chosenVariables(options, source, template);
  const problem = templateProblem(template, Object.keys(variables));
  if (problem !== undefined) throw usage(`read --url-template "${template}": ${problem}`);
  const needsCorner = placeholdersOf(template).some((name) => ['E', 'N', 'x', 'y'].includes(name));
  const squares = chosenSquares(options, source, source === undefined && !needsCorner);
  if (squares === undefined)
    throw usage('choose squares: none given; allowed: --squares a,b,... or --bbox west,south,east,north');
  return {
    profile: source === undefined ? adHocProfile(options, 'adhoc') : profileOf(source),
    squares,
    urlOf: (square) => expandTemplate(template, square, variables),
  };
}

function chosenVariables(options: SelectionOptions, source: Source | undefined, template: string): Variables {
  const given: Variables = { ...options.set, ...(options.block === undefined ? {} : { block: options.block }) };
  const used = placeholdersOf(template);
  const needless = Object.keys(given).find((name) => !used.includes(name));
  if (needless !== undefined)
    throw usage(`set ${needless}: the address "${template}" has no {${needless}}; allowed: its own placeholders`);
  for (const [name, variable] of Object.entries(source?.variables ?? {})) {
    if (!used.includes(name)) continue;
    const value = given[name];
    const how = name === 'block' ? '--block' : `--set ${name}=`;
    if (value === undefined)
      throw usage(
        `choose squares of ${source?.id ?? ''}: ${name} (${variable.about}) is missing; allowed: ${how} with ${variable.allowed}`,
      );
    if (!new RegExp(`^(?:${variable.pattern})$`).test(value))
      throw usage(`set ${name}: "${value}"; allowed: ${variable.allowed}`);
  }
  return given;
}
