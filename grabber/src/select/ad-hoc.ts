import type { Terms, CatalogueSquare, Catalogue, Region } from '../model/store.js';
import type { SourceVariable } from '../sources/access-schema.js';
import {
  hostOfTemplate,
  originOfTemplate,
  type AccessProfile,
  listVariables,
  type Source,
} from '../sources/source.js';
import {
  listPlaceholders,
  templateProblem,
  type Variables,
  kMaxSquares,
  type Square,
  expandTemplate,
  parseSquare,
} from '../sources/square.js';
import type { SelectionOptions } from './selection.js';
import { usage } from '../util/errors.js';
import { gridSquare, gridSquares, inOrder } from '../sources/catalogue/template-catalogue.js';

/** Grid of addresses that were typed. */
export const kAdHocSquareM = 1000;
const kAdHocConcurrent = 4;
const kCornerNames = ['E', 'N', 'x', 'y'];

/** Facts that the user gave of files whose source has no configuration. */
export function adHocTerms(options: SelectionOptions): Terms {
  return {
    crs: options.crs ?? null,
    classTable: null,
    licence: options.licence ?? null,
    attribution: options.attribution ?? null,
  };
}

/** @param template the address that was typed; undefined = no host may be contacted */
export function adHocProfile(
  options: SelectionOptions,
  template: string | undefined,
  square_m: number | null,
): AccessProfile {
  const isPrivate = template !== undefined && options.allowPrivate === true;
  return {
    max_concurrent: kAdHocConcurrent,
    max_per_s: null,
    missing_status: options.missingStatus ?? [404],
    hosts: template === undefined ? [] : [hostOfTemplate(template)],
    privateOrigins: isPrivate ? [originOfTemplate(template)] : [],
    secretHeaders: {},
    secretOrigins: [],
    square_m,
  };
}

/** Whether squares of the address are places of a grid, not just names. */
export function needsCorner(template: string): boolean {
  return listPlaceholders(template).some((name) => kCornerNames.includes(name));
}

/** Values the user gave, with --block as one of them. */
export function givenVariables(options: SelectionOptions): Variables {
  return { ...options.set, ...(options.block === undefined ? {} : { block: options.block }) };
}

/** @throws GrabberError USAGE for an address that cannot be used, or a value it has no place for */
export function checkTemplate(template: string, given: Variables, known: readonly string[]): void {
  const problem = templateProblem(template, [...new Set([...known, ...Object.keys(given)])]);
  if (problem !== undefined) throw usage(`read --url-template "${template}": ${problem}`);
  const unused = Object.keys(given).find((name) => !listPlaceholders(template).includes(name));
  if (unused !== undefined) {
    throw usage(
      `set ${unused}: the address "${template}" has no {${unused}}; allowed: its own ` +
        'placeholders',
    );
  }
}

/**
 * Replaces the addresses of a source by the one that was typed; variables without a description may
 * hold any text.
 */
export function withTemplate(source: Source, template: string, given: Variables): Source {
  const own = listVariables(source);
  checkTemplate(template, given, Object.keys(own));
  const used = listPlaceholders(template);
  const typed = Object.keys(given).map((name): [string, SourceVariable] => [
    name,
    { about: 'typed', pattern: '.+', allowed: 'any text' },
  ]);
  const variables = Object.fromEntries(
    [...typed, ...Object.entries(own)].filter(([name]) => used.includes(name)),
  );
  return {
    ...source,
    hosts: [...source.hosts, hostOfTemplate(template)],
    access: { kind: 'template', urls: [template], variables },
  };
}

/**
 * Squares at an address that was typed.
 * @param plainNames names are just names, no places of a grid
 */
export function adHocCatalogue(template: string, given: Variables, plainNames: boolean): Catalogue {
  const toUrls = (square: Square): string[] => [expandTemplate(template, square, given)];
  function* list(region: Region): Generator<CatalogueSquare> {
    if (plainNames && region.names !== undefined) {
      for (const name of region.names) {
        yield nameOnlySquare(name, toUrls({ name, corner: undefined }));
      }
      return;
    }
    for (const square of gridSquares(region, { square_m: kAdHocSquareM, extent_m: undefined })) {
      yield gridSquare(square, kAdHocSquareM, null, toUrls(square));
    }
  }
  return {
    find: (region, signal) => inOrder(`list ${template}`, kMaxSquares, list(region), signal),
  };
}

/** A file of which only the name is known. */
export function nameOnlySquare(name: string, urls: readonly string[]): CatalogueSquare {
  return gridSquare({ name, corner: undefined }, kAdHocSquareM, null, urls);
}

/**
 * Adds the squares that were requested by name and that the catalogue lacks, last and without
 * addresses; locate() finds none for them, so that they are reported as missing.
 * @param complete called at the end: false when unreadable entries may hold a square, which then
 *   must not be reported as missing
 */
export function withRequestedNames(
  catalogue: Catalogue,
  square_m: number | null,
  complete: () => boolean,
): Catalogue {
  const unlisted = new Set<string>();
  async function* find(region: Region, signal: AbortSignal): AsyncGenerator<CatalogueSquare> {
    const left = new Set(region.names);
    for await (const square of catalogue.find(region, signal)) {
      left.delete(square.name);
      yield square;
    }
    if (!complete()) return;
    for (const name of left) {
      unlisted.add(name);
      yield square_m === null
        ? nameOnlySquare(name, [])
        : gridSquare(parseSquare(name, { square_m, extent_m: undefined }), square_m, null, []);
    }
  }
  return {
    find,
    locate: async (square, near, exists, signal) =>
      unlisted.has(square.name)
        ? undefined
        : await catalogue.locate?.(square, near, exists, signal),
  };
}
