import type { Terms } from '../model/square.js';
import type { SourceVariable } from '../sources/access-schema.js';
import { hostOfTemplate, originOfTemplate } from '../sources/hosts.js';
import type { AccessProfile } from '../sources/profile.js';
import { listVariables, type Source } from '../sources/source.js';
import { listPlaceholders, templateProblem, type Variables } from '../sources/url-template.js';
import type { SelectionOptions } from './selection.js';
import { usage } from './usage.js';

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
