import { GrabberError } from '../util/errors.js';
import { matches, type SourceVariables } from './access-schema.js';
import { listTemplates, listVariables, type Source } from './source.js';
import { listPlaceholders, type Variables } from './url-template.js';

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

function usage(message: string): GrabberError {
  return new GrabberError('USAGE', message);
}
