import { join } from 'node:path';
import { Option, type Command } from 'commander';
import type { CliContext } from './context.js';
import {
  collectVariable,
  parseBox,
  parseBoxDeg,
  parseCircle,
  parseCircleDeg,
  parseCrs,
  parseNameList,
  parseSourceId,
  parseStatusList,
} from './option-parsers.js';

/** Everything that SelectionOptions holds: which source, which ground. */
export function addSelectionOptions(command: Command, context: CliContext): Command {
  command
    .option('--source <id>', 'source of the squares, one of those that "sources" lists')
    .option('--from <folder>', 'take LAZ, LAS and zLAS files of this folder instead of the web');
  addVariableOptions(addRegionOptions(command, context));
  return command
    .option(
      '--url-template <url>',
      "address to use instead of the source's: {E} {N} km, {x} {y} m, {name}; {x:06} pads",
    )
    .option(
      '--as <id>',
      'without --source: folder name in the store (default: adhoc, or local with --from)',
      parseSourceId,
    )
    .option(
      '--crs <code>',
      'without --source: CRS of files that carry none, such as EPSG:3794',
      parseCrs,
    )
    .option('--licence <text>', 'without --source: licence to record')
    .option('--attribution <text>', 'without --source: attribution to record')
    .addOption(
      new Option(
        '--missing-status <list>',
        'without --source: statuses that mean "no such square" (default: 404)',
      ).argParser(parseStatusList),
    )
    .option(
      '--allow-private',
      'without --source: this address (scheme, host, port) may be in a private network, or ' +
        'on this machine',
    );
}

/** Which ground; exactly one of them chooses. */
export function addRegionOptions(command: Command, context: CliContext): Command {
  return command
    .option('--area <name>', 'a named area, one of those that "areas" lists, such as Bled')
    .option(
      '--squares <names>',
      'squares E_N (south-west corner, km) or ranges E_N:E_N, separated by commas',
      parseNameList,
    )
    .option(
      '--bbox <w,s,e,n>',
      "all squares that touch this box, metres in the source's CRS",
      parseBox,
    )
    .option('--bbox-deg <w,s,e,n>', 'all squares that touch this box, degrees', parseBoxDeg)
    .option(
      '--circle <e,n,r>',
      "all squares that touch this circle, metres in the source's CRS",
      parseCircle,
    )
    .option(
      '--circle-deg <lon,lat,r>',
      'all squares that touch this circle, degrees and metres',
      parseCircleDeg,
    )
    .option(
      '--polygon <file>',
      'all squares that touch the polygons of a Shapefile, GeoJSON, GeoPackage, FlatGeobuf ' +
        'or KML file',
    )
    .hook('preAction', () => {
      command.setOptionValue('areasFolder', join(context.configFolder(), 'areas'));
    });
}

/** What addresses leave open. */
export function addVariableOptions(command: Command): Command {
  return command
    .option('--block <name>', 'short for --set block=<name>')
    .option(
      '--set <name=value>',
      "value of a source's own placeholder; may be repeated",
      collectVariable,
    );
}
