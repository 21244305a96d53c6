import { isAbsolute } from 'node:path';
import type { Argument, Command, Option } from 'commander';

/**
 * What --help says of a command and its subcommands, in the form of
 * common/util/command_line.hpp: man pages and completions are made of it.
 */
export type OptionTable = {
  readonly name: string;
  readonly description: string;
  readonly footer: string;
  readonly options: readonly TableRow[];
  readonly commands: readonly OptionTable[];
};

type TableRow = {
  readonly names: readonly string[];
  readonly positional: string;
  readonly group: string;
  readonly text: string;
  readonly default: string;
  readonly required: boolean;
  readonly repeats: boolean;
  /** "" of a flag that takes none. */
  readonly value: string;
  /** All values, or none. */
  readonly words: readonly string[];
};

export function optionTable(command: Command): OptionTable {
  const help = command.createHelp();
  return {
    name: command.name(),
    description: command.description(),
    footer: '',
    options: [
      ...command.registeredArguments.map(ofArgument),
      ...help.visibleOptions(command).map(ofOption),
    ],
    commands: help
      .visibleCommands(command)
      .filter((each) => each.name() !== 'help')
      .map(optionTable),
  };
}

function ofOption(option: Option): TableRow {
  return {
    names: [option.short, option.long].filter((name) => name !== undefined && name !== null),
    positional: '',
    group: 'Options',
    text: option.description,
    default: formatDefault(option.defaultValue),
    required: option.mandatory,
    repeats: option.variadic,
    value: /[<[](.*)[>\]]/.exec(option.flags)?.[1] ?? '',
    words: option.argChoices ?? [],
  };
}

function ofArgument(argument: Argument): TableRow {
  return {
    names: [],
    positional: argument.name(),
    group: 'Options',
    text: argument.description,
    default: formatDefault(argument.defaultValue),
    required: argument.required,
    repeats: argument.variadic,
    value: argument.name(),
    words: argument.argChoices ?? [],
  };
}

/** A path of this machine is no default that a page could name. */
function formatDefault(value: unknown): string {
  if (typeof value === 'number') return String(value);
  return typeof value === 'string' && !isAbsolute(value) ? value : '';
}
