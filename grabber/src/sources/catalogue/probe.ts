import type { CatalogueSquare } from '../../model/square.js';
import type { Source } from '../source.js';
import { listTemplates } from '../source.js';
import type { Square } from '../square.js';
import { expandTemplate, listPlaceholders, type Variables } from '../url-template.js';
import type { ChosenVariables } from '../variables.js';

/** Checks whether a file exists at an address; counts as a request to its host. */
export type FileProbe = (url: string, signal: AbortSignal) => Promise<boolean>;

/** Addresses of squares that follow a rule. */
export type Addresses = {
  /**
   * @param block of the square, null when not known; then the list is empty if an address needs
   * it
   */
  of(square: Square, block: string | null): string[];
  /**
   * Tries blocks one after the other.
   * @param near most likely first
   */
  locate(
    square: CatalogueSquare,
    corner: Square,
    near: readonly string[],
    exists: FileProbe,
    signal: AbortSignal,
  ): Promise<CatalogueSquare | undefined>;
};

/** @param blockVariable the placeholder that is the block of a square, see findBlockVariable */
export function makeAddresses(
  source: Source,
  chosen: ChosenVariables,
  blockVariable: string | undefined,
): Addresses {
  const templates = listTemplates(source);
  const { given, probed } = chosen;
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
    of(square, block) {
      const known = block === null || blockVariable === undefined ? {} : { [blockVariable]: block };
      return probed !== undefined && known[probed.name] === undefined ? [] : expand(square, known);
    },
    async locate(square, corner, near, exists, signal) {
      if (probed === undefined) return { ...square, urls: expand(corner, {}) };
      for (const { value, rank } of attempts(probed.values, near, templates.length)) {
        const urls = expand(corner, { [probed.name]: value });
        const url = urls[rank];
        if (url === undefined || !(await exists(url, signal))) continue;
        return { ...square, block: value, urls: [url, ...urls.filter((other) => other !== url)] };
      }
      return undefined;
    },
  };
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
