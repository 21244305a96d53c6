import { usage } from '../util/errors.js';
import { matches, type SourceVariables } from './access-schema.js';
import { listTemplates, listVariables, type Source } from './source.js';
import {
  listPlaceholders,
  type Variables,
  type Square,
  expandTemplate,
  parseSquare,
  type Grid,
} from './square.js';
import type { Catalogue } from '../model/store.js';

/** What is known before any square is requested. */
export type ChosenVariables = {
  readonly given: Variables;
  /**
   * The one variable that is found by trying, with all its possible values; undefined when
   * nothing is left open.
   */
  readonly probed: { readonly name: string; readonly values: readonly string[] } | undefined;
};

/** @throws GrabberError USAGE for a value that is missing, needless or not allowed */
export function chooseVariables(source: Source, given: Variables): ChosenVariables {
  const all = listVariables(source);
  refuseUnused(source, all, given);
  const values: Record<string, string> = {};
  let probed: ChosenVariables['probed'];
  for (const [name, variable] of Object.entries(all)) {
    const value = given[name] ?? variable.value;
    if (value !== undefined) {
      if (!matches(variable.pattern, value)) {
        throw usage(`set ${name}: "${value}"; allowed: ${variable.allowed}`);
      }
      values[name] = value;
    } else if (variable.values !== undefined) {
      probed = { name, values: variable.values };
    } else {
      const how = name === 'block' ? '--block' : `--set ${name}=`;
      throw usage(
        `choose squares of ${source.id}: ${name} (${variable.about}) is missing; allowed: ` +
          `${how} with ${variable.allowed}`,
      );
    }
  }
  return { given: values, probed };
}

function refuseUnused(source: Source, all: SourceVariables, given: Variables): void {
  const unused = Object.keys(given).find((name) => all[name] === undefined);
  if (unused === undefined) return;
  const own = Object.keys(all).join(', ') || 'none, its addresses leave nothing open';
  throw usage(`set ${unused}: source ${source.id} has no {${unused}}; allowed: ${own}`);
}

/**
 * The name of the variable that is a square's block: the one found by trying, else one named so.
 */
export function findBlockVariable(source: Source): string | undefined {
  const all = listVariables(source);
  const names = Object.keys(all).filter((name) =>
    listTemplates(source).some((url) => listPlaceholders(url).includes(name)),
  );
  return (
    names.find((name) => all[name]?.values !== undefined) ?? names.find((name) => name === 'block')
  );
}

/** Addresses of squares that follow a rule. */
export type Addresses = {
  /** Of all squares, where the user gave it; else null. */
  readonly block: string | null;
  /**
   * @param block of the square, null when not known; then the list is empty if an address needs
   * it
   */
  of(square: Square, block: string | null): string[];
  /** Tries blocks one after the other; undefined where nothing is left open. */
  readonly locate: Catalogue['locate'];
};

/** @throws GrabberError USAGE for a value that is missing, needless or not allowed */
export function makeAddresses(source: Source, variables: Variables): Addresses {
  const { given, probed } = chooseVariables(source, variables);
  const blockVariable = findBlockVariable(source);
  const templates = listTemplates(source);
  const expand = (square: Square, more: Variables): string[] =>
    templates
      .filter(
        (template) =>
          probed === undefined ||
          more[probed.name] !== undefined ||
          !listPlaceholders(template).includes(probed.name),
      )
      .map((template) => expandTemplate(template, square, { ...given, ...more }));

  return {
    block: blockVariable === undefined ? null : (given[blockVariable] ?? null),
    of(square, block) {
      const known = block === null || blockVariable === undefined ? {} : { [blockVariable]: block };
      return probed !== undefined && known[probed.name] === undefined ? [] : expand(square, known);
    },
    locate:
      probed &&
      (async (square, near, exists, signal) => {
        const corner = parseSquare(square.name, toGrid(source));
        for (const { value, rank } of attempts(probed.values, near, templates.length)) {
          const urls = expand(corner, { [probed.name]: value });
          const url = urls[rank];
          if (url === undefined || !(await exists(url, signal))) continue;
          return { ...square, block: value, urls: [url, ...urls.filter((other) => other !== url)] };
        }
        return undefined;
      }),
  };
}

/** The grid of a source with one, in whose squares its addresses are. */
export function toGrid({ square_m = 1000, extent_m }: Source): Grid {
  return { square_m, extent_m };
}

/**
 * Blocks of neighbours with all their addresses first, for squares of a block lie together. Then
 * the best address of every other block, and only then the lesser ones, which are mostly other
 * spellings of the same file.
 */
function* attempts(
  values: readonly string[],
  near: readonly string[],
  ranks: number,
): Generator<{ value: string; rank: number }> {
  const likely = [...new Set(near)].filter((value) => values.includes(value));
  const others = values.filter((value) => !likely.includes(value));
  for (const value of likely) for (let rank = 0; rank < ranks; ++rank) yield { value, rank };
  for (let rank = 0; rank < ranks; ++rank) for (const value of others) yield { value, rank };
}
