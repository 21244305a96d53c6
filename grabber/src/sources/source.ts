import { z } from 'zod';
import { accessSchema, kAccessAllowed, type SourceVariables } from './access-schema.js';
import { listPlaceholders, templateProblem } from './square.js';
import { loadConfigFolder, parseConfig, type ConfigKind } from '../config/toml-file.js';
import type { Terms } from '../model/store.js';

/** Folder names in the store, so no dots, slashes or capitals. */
export const kSourceId = /^[a-z0-9][a-z0-9-]{0,39}$/;
export const kSourceIdAllowed = 'lower-case letters, digits and "-", at most 40, such as si-lss';

/** What each field of a source file may hold; also the text of the error when it does not. */
export const kAllowed = {
  id: `${kSourceIdAllowed}, the same as the file name`,
  title: 'text of 1 to 200 characters',
  licence: 'text of 1 to 200 characters',
  attribution: 'text of 1 to 200 characters',
  crs: 'EPSG:<number>, such as EPSG:3794',
  crs_in_files:
    'true or false, true where each file says its own CRS and crs is that of the catalogue only',
  square_m:
    'a multiple of 1000 from 1000 to 100000, metres; left out only for STAC catalogues ' +
    'whose files have no grid',
  extent_m: '[west, south, east, north] in metres with west < east and south < north',
  class_table: 'lower-case letters, digits and "-", the name of a file in config/classes',
  max_concurrent: 'an integer from 1 to 32, requests at a time',
  max_per_s: 'a number from 0.01 to 1000, requests a second',
  missing_status: 'a list of HTTP statuses from 400 to 499',
  hosts:
    'a list of host names without scheme or path, such as assets.example.org or ' +
    'assets.example.org:8080',
  allow_private_addresses: 'true or false',
  secret_headers: 'a table [secret_headers] of header = "NAME_OF_ENVIRONMENT_VARIABLE"',
  ...kAccessAllowed,
} as const;

const text = z.string().min(1).max(200);
const kLabel = '[a-z0-9]([a-z0-9-]*[a-z0-9])?';
/**
 * "host" is any port of a public host, and of a private one the ports of http and https;
 * "host:port" this port.
 */
export const hostName = z
  .string()
  .regex(new RegExp(`^(?=.{1,259}$)${kLabel}(\\.${kLabel})*(:[1-9]\\d{0,4})?$`))
  .refine((name) => URL.canParse(`http://${name}`));

export const sourceSchema = z
  .strictObject({
    id: z.string().regex(kSourceId),
    title: text,
    licence: text,
    attribution: text,
    crs: z.string().regex(/^EPSG:\d{4,6}$/),
    crs_in_files: z.boolean().default(false),
    square_m: z.int().min(1000).max(100_000).multipleOf(1000).optional(),
    extent_m: z
      .tuple([z.number(), z.number(), z.number(), z.number()])
      .refine(([west, south, east, north]) => west < east && south < north),
    class_table: z.string().regex(kSourceId),
    max_concurrent: z.int().min(1).max(32),
    max_per_s: z.number().min(0.01).max(1000).optional(),
    missing_status: z.array(z.int().min(400).max(499)),
    hosts: z.array(hostName).default([]),
    allow_private_addresses: z.boolean().default(false),
    secret_headers: z
      .record(
        z.string().regex(/^[A-Za-z][A-Za-z0-9-]*$/),
        z.string().regex(/^[A-Za-z_][A-Za-z0-9_]*$/),
      )
      .default({}),
    access: accessSchema,
  })
  .superRefine((source, context) => {
    const problem = addressProblem(source.access);
    if (problem !== undefined) {
      context.addIssue({
        code: 'custom',
        path: ['access', problem.field],
        message: problem.message,
      });
    }
    const gridless = source.access.kind === 'stac' && source.access.name_pattern === undefined;
    if (source.square_m === undefined && !gridless) {
      context.addIssue({ code: 'custom', path: ['square_m'] });
    }
  });

/** One open-data portal. */
export type Source = z.infer<typeof sourceSchema>;

/**
 * What the addresses of a source leave open; sources whose catalogue lists the addresses have none.
 */
export function listVariables(source: Source): SourceVariables {
  return source.access.kind === 'stac' ? {} : source.access.variables;
}

/** Addresses made of a square's name, best first; empty where the catalogue lists them. */
export function listTemplates(source: Source): readonly string[] {
  return source.access.kind === 'stac' ? [] : (source.access.urls ?? []);
}

function addressProblem(access: Source['access']): { field: string; message: string } | undefined {
  if (access.kind === 'stac') return undefined;
  const urls = access.urls ?? [];
  const names = Object.keys(access.variables);
  for (const url of urls) {
    const message = templateProblem(url, names);
    if (message !== undefined) return { field: 'urls', message };
  }
  const unused = names.find((name) => !urls.some((url) => listPlaceholders(url).includes(name)));
  if (unused !== undefined) {
    return { field: 'variables', message: `${unused}, which no address uses` };
  }
  const probed = names.filter((name) => access.variables[name]?.values !== undefined);
  // The row of a square keeps only one found value, its block.
  if (probed.length > 1) {
    return {
      field: 'variables',
      message: `values for ${probed.join(' and ')}, where one can be found by trying`,
    };
  }
  return undefined;
}

const kKind: ConfigKind<Source> = { what: 'source', schema: sourceSchema, allowed: kAllowed };

export function loadSources(
  folder: string,
  signal: AbortSignal,
): Promise<ReadonlyMap<string, Source>> {
  return loadConfigFolder(folder, kKind, signal);
}

/** @param path used for messages, and its stem must be the source's id */
export function parseSource(toml: string, path: string): Source {
  return parseConfig(toml, path, kKind);
}

/** Limits and permissions for requests to the hosts of a source. */
export type AccessProfile = {
  /** Requests at a time, 1 to 32. */
  readonly max_concurrent: number;
  /** Requests a second, null = as fast as `max_concurrent` allows. */
  readonly max_per_s: number | null;
  /** HTTP statuses that mean "no such square". */
  readonly missing_status: readonly number[];
  /** Host names in lower case that may be contacted (sources/hosts.ts). */
  readonly hosts: readonly string[];
  /** Origins that may lead to loopback, link-local and private addresses (sources/hosts.ts). */
  readonly privateOrigins: readonly string[];
  /**
   * Header name -> NAME of the environment variable that holds its value; neither value nor header
   * is ever logged.
   */
  readonly secretHeaders: Readonly<Record<string, string>>;
  /** Origins that may receive the secret headers, as URL.origin writes them (sources/hosts.ts). */
  readonly secretOrigins: readonly string[];
  /** Edge of a square; null where files have no grid. */
  readonly square_m: number | null;
};

export function toProfile(source: Source): AccessProfile {
  return {
    max_concurrent: source.max_concurrent,
    max_per_s: source.max_per_s ?? null,
    missing_status: source.missing_status,
    hosts: listHosts(source),
    privateOrigins: listPrivateOrigins(source),
    secretHeaders: source.secret_headers,
    secretOrigins: listSecretOrigins(source),
    square_m: source.square_m ?? null,
  };
}

/** What is recorded with the files of a source. */
export function toTerms(source: Source): Terms {
  return {
    crs: source.crs_in_files ? null : source.crs,
    classTable: source.class_table,
    licence: source.licence,
    attribution: source.attribution,
  };
}

/**
 * Replaces the variables of an address. None can stand in its host, so that a value cannot choose
 * the host.
 */
function withoutVariables(template: string): URL {
  return new URL(template.replace(/\{[^}]*\}/g, '0'));
}

export function hostOfTemplate(template: string): string {
  return withoutVariables(template).hostname.toLowerCase();
}

export function originOfTemplate(template: string): string {
  return withoutVariables(template).origin;
}

/** Origins of a host without a scheme: its port if it has one, else those of http and https. */
export function originsOfHost(host: string): string[] {
  return ['http', 'https'].map((scheme) => new URL(`${scheme}://${host}`).origin);
}

/**
 * Hosts that a source may contact, in lower case, without a port unless the source names one;
 * sorted.
 */
export function listHosts(source: Source): string[] {
  return [...new Set([...listAddresses(source).map(hostOfTemplate), ...source.hosts])].sort();
}

/**
 * Origins that may receive the source's secrets: those of its own addresses, not all permitted
 * hosts.
 */
export function listSecretOrigins(source: Source): string[] {
  return [...new Set(listAddresses(source).map(originOfTemplate))].sort();
}

/**
 * Origins that may resolve to private addresses: all that a source names when it allows them, else
 * none.
 */
export function listPrivateOrigins(source: Source): string[] {
  if (!source.allow_private_addresses) return [];
  return [
    ...new Set([...listSecretOrigins(source), ...source.hosts.flatMap(originsOfHost)]),
  ].sort();
}

function listAddresses(source: Source): string[] {
  const { access } = source;
  const addresses = [...listTemplates(source)];
  if (access.kind === 'stac') {
    addresses.push(access.items, ...(access.sign === undefined ? [] : [access.sign]));
  }
  if (access.kind === 'wfs') addresses.push(access.url);
  return addresses;
}
