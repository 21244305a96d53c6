import { join } from 'node:path';
import type { Command } from 'commander';
import { measureExtent, loadAreas } from '../select/areas.js';
import type { CliContext } from './context.js';
import { formatTable } from './output.js';

export function addAreasCommand(program: Command, context: CliContext): void {
  program
    .command('areas')
    .description('list the areas for --area')
    .option('--json', 'print JSON')
    .action(async ({ json }: { json?: boolean }) => {
      const areas = await loadAreas(join(context.configFolder(), 'areas'), context.signal);
      if (json === true) {
        context.output.out(`${JSON.stringify(areas, undefined, 2)}\n`);
        return;
      }
      const rows = areas.map((area) => {
        const { lon, lat, width_m, height_m } = measureExtent(area);
        return [
          area.name,
          `${lat.toFixed(3)} N`,
          `${lon.toFixed(3)} E`,
          `${km(width_m)} x ${km(height_m)} km`,
          area.title,
        ];
      });
      context.output.out(formatTable(['name', 'latitude', 'longitude', 'size', 'title'], rows));
    });
}

function km(metres: number): string {
  return (metres / 1000).toFixed(1);
}
