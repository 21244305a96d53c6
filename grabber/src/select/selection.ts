import { resolve } from 'node:path';
import type { BoundsDeg } from '../geo/bounds.js';
import type { HttpClient } from '../fetch/http-client.js';
import type { Catalogue, Region, BoundsM, Terms } from '../model/store.js';
import { type GrabberError, usage } from '../util/errors.js';
import { openCatalogue } from '../sources/catalogue/open-catalogue.js';
import type { CatalogueOptions } from '../sources/catalogue/listing.js';
import {
  originOfTemplate,
  listSecretOrigins,
  toProfile,
  toTerms,
  type AccessProfile,
  type Source,
} from '../sources/source.js';
import type { Variables } from '../sources/square.js';
import {
  adHocCatalogue,
  adHocProfile,
  adHocTerms,
  checkTemplate,
  givenVariables,
  kAdHocSquareM,
  needsCorner,
  withTemplate,
  withRequestedNames,
} from './ad-hoc.js';
import { openFolder } from './folder-catalogue.js';
import {
  kAll,
  chosenRegion,
  chosenRegionOption,
  kRegionOptionNames,
  type GridInfo,
} from './region.js';

/**
 * The options of the command line for sources and ground; cli/selection.ts makes them
 * (`addSelectionOptions`).
 */
export type SelectionOptions = {
  source?: string;
  urlTemplate?: string;
  /** A folder of point clouds instead of the web. */
  from?: string;
  as?: string;
  crs?: string;
  licence?: string;
  attribution?: string;
  missingStatus?: number[];
  allowPrivate?: boolean;
  block?: string;
  set?: Variables;

  squares?: string[];
  bbox?: BoundsM;
  bboxDeg?: BoundsDeg;
  circle?: readonly [number, number, number];
  circleDeg?: readonly [number, number, number];
  polygon?: string;
  area?: string;
  /** Where --area looks; addSelectionOptions fills it in. */
  areasFolder?: string;
};

/** Which squares of which source, and the limits for requests to its hosts. */
export type Selection = {
  /** Folder name in the store. */
  readonly source: string;
  /** Of LiDAR squares the same as `source`. */
  readonly grid: string;
  readonly gridCrs: string | null;
  readonly terms: Terms;
  readonly profile: AccessProfile;
  /** A local folder is a catalogue whose urls are file: addresses. */
  readonly catalogue: Catalogue;
  readonly region: Region;
  /** With --from: files whose name is not one of the source's. */
  readonly ignored: readonly string[];
};

/** How requests to a catalogue are retried and reported. */
type CatalogueMonitoring = Pick<CatalogueOptions, 'policy' | 'onRetry' | 'onLeftOut'>;

/**
 * Turns the command line into squares and their access. Reads area and polygon files, and contacts
 * no host. The catalogue lists every square that was requested by name; one that the source lacks
 * has no addresses, and `locate` finds none.
 * @throws GrabberError USAGE, POLYGON_FILE or CONFIG
 */
export async function select(
  options: SelectionOptions,
  sources: ReadonlyMap<string, Source>,
  http: HttpClient,
  signal: AbortSignal,
  monitor: CatalogueMonitoring = {},
): Promise<Selection> {
  chosenRegionOption(options);
  let complete = true;
  const { onLeftOut } = monitor;
  const countLeftOut = (error: GrabberError): void => {
    complete = false;
    onLeftOut?.(error);
  };
  const source = findSource(options, sources);
  const counted = onLeftOut === undefined ? monitor : { ...monitor, onLeftOut: countLeftOut };
  const selection = await selectFrom(options, source, http, counted, signal);
  return {
    ...selection,
    catalogue: withRequestedNames(selection.catalogue, selection.profile.square_m, () => complete),
  };
}

function selectFrom(
  options: SelectionOptions,
  source: Source | undefined,
  http: HttpClient,
  monitor: CatalogueMonitoring,
  signal: AbortSignal,
): Promise<Selection> {
  if (options.from !== undefined) return fromFolder(options.from, options, source, signal);
  if (source !== undefined) return fromSource(options, source, http, monitor, signal);
  return fromTemplate(options, signal);
}

async function fromSource(
  options: SelectionOptions,
  configured: Source,
  http: HttpClient,
  monitor: CatalogueMonitoring,
  signal: AbortSignal,
): Promise<Selection> {
  const given = givenVariables(options);
  const source =
    options.urlTemplate === undefined
      ? configured
      : withTemplate(configured, options.urlTemplate, given);
  const catalogue = openCatalogue(source, http, { ...monitor, variables: given });
  return {
    ...toRecordFields(source),
    profile: profileWithTemplate(source, configured, options.urlTemplate),
    catalogue,
    region: await neededRegion(options, toGridInfo(source), signal),
    ignored: [],
  };
}

/**
 * Permits the origin of a typed address to be private; secrets are for the addresses in the
 * source's file only.
 */
function profileWithTemplate(
  source: Source,
  configured: Source,
  template: string | undefined,
): AccessProfile {
  const profile = { ...toProfile(source), secretOrigins: listSecretOrigins(configured) };
  if (template === undefined) return profile;
  return { ...profile, privateOrigins: [...profile.privateOrigins, originOfTemplate(template)] };
}

/** What the store records of squares of a source. */
export function toRecordFields(
  source: Source,
): Pick<Selection, 'source' | 'grid' | 'gridCrs' | 'terms'> {
  return { source: source.id, grid: source.id, gridCrs: source.crs, terms: toTerms(source) };
}

export function toGridInfo(source: Source): GridInfo {
  return { crs: source.crs, square_m: source.square_m ?? null, extent_m: source.extent_m };
}

async function fromTemplate(options: SelectionOptions, signal: AbortSignal): Promise<Selection> {
  const template = options.urlTemplate;
  if (template === undefined) {
    throw usage(
      'choose source: none given; allowed: --source ID, --url-template URL or --from FOLDER',
    );
  }
  const given = givenVariables(options);
  checkTemplate(template, given, []);
  const plainNames = !needsCorner(template);
  const square_m = plainNames && options.squares !== undefined ? null : kAdHocSquareM;
  return {
    ...adHocRecords(options, 'adhoc'),
    profile: adHocProfile(options, template, square_m),
    catalogue: adHocCatalogue(template, given, plainNames),
    region: await neededRegion(
      options,
      { crs: options.crs ?? null, square_m, extent_m: undefined },
      signal,
    ),
    ignored: [],
  };
}

async function fromFolder(
  from: string,
  options: SelectionOptions,
  source: Source | undefined,
  signal: AbortSignal,
): Promise<Selection> {
  const folder = resolve(from);
  const unused = {
    '--url-template': options.urlTemplate,
    '--block': options.block,
    '--set': options.set,
    '--missing-status': options.missingStatus,
    '--allow-private': options.allowPrivate,
  };
  const conflict = Object.entries(unused).find(([, value]) => value !== undefined);
  if (conflict !== undefined) {
    throw usage(
      `read folder ${folder}: ${conflict[0]} with --from; allowed: only for web addresses`,
    );
  }
  const regionOption = chosenRegionOption(options);
  if (source?.square_m === undefined && regionOption !== undefined && regionOption !== 'squares') {
    throw usage(
      'choose squares: a place with --from but without a grid; allowed: --squares, or ' +
        '--source ID whose file names give the place',
    );
  }
  const { catalogue, ignored } = await openFolder(folder, source, signal);
  const gridInfo =
    source === undefined ? { crs: null, square_m: null, extent_m: undefined } : toGridInfo(source);
  return {
    ...(source === undefined ? adHocRecords(options, 'local') : toRecordFields(source)),
    profile: source === undefined ? adHocProfile(options, undefined, null) : toProfile(source),
    catalogue,
    region: (await chosenRegion(options, gridInfo, signal)) ?? kAll,
    ignored,
  };
}

function adHocRecords(
  options: SelectionOptions,
  id: string,
): Pick<Selection, 'source' | 'grid' | 'gridCrs' | 'terms'> {
  const name = options.as ?? id;
  return { source: name, grid: name, gridCrs: options.crs ?? null, terms: adHocTerms(options) };
}

async function neededRegion(
  options: SelectionOptions,
  gridInfo: GridInfo,
  signal: AbortSignal,
): Promise<Region> {
  const region = await chosenRegion(options, gridInfo, signal);
  if (region === undefined) {
    throw usage(`choose squares: none given; allowed: one of ${kRegionOptionNames}`);
  }
  return region;
}

/**
 * @return undefined without --source
 * @throws GrabberError USAGE
 */
export function findSource(
  options: SelectionOptions,
  sources: ReadonlyMap<string, Source>,
): Source | undefined {
  if (options.source === undefined) return undefined;
  const source = sources.get(options.source);
  if (source === undefined) {
    throw usage(
      `choose source: "${options.source}"; allowed: ` +
        `${[...sources.keys()].join(', ') || 'none, the sources folder is empty'}`,
    );
  }
  const ownOptions = {
    '--as': options.as,
    '--crs': options.crs,
    '--licence': options.licence,
    '--attribution': options.attribution,
    '--missing-status': options.missingStatus,
    '--allow-private': options.allowPrivate,
  };
  const conflict = Object.entries(ownOptions).find(([, value]) => value !== undefined);
  if (conflict !== undefined) {
    throw usage(
      `choose source: ${conflict[0]} with --source ${source.id}; allowed: only without --source`,
    );
  }
  return source;
}
