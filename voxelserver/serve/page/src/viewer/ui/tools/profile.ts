/** Heights along a line of clicked points: a chart, its facts, and a table to take away. */
import { button, download, element, setFacts } from '../../../dom.js';
import type { Shape } from '../overlay.js';
import { makeProfileChart } from '../profile-chart.js';
import {
  toCsv,
  toFacts,
  finest,
  placesAlong,
  raysDown,
  makeSamples,
  type ProfileSample,
} from '../profile-line.js';
import type { Tool, ToolContext } from '../tool.js';
import { makePointLine } from './point-line.js';

const kCsvName = 'profile.csv';

export function makeProfile(context: ToolContext): Tool {
  const { say, numbers, world } = context;
  let samples: readonly ProfileSample[] = [];
  const facts = element('dl', { id: 'profile-facts', 'aria-live': 'polite' });
  const line = makePointLine(context, 'profile', () => read(true));
  const chart = makeProfileChart(say, numbers, () => context.changed());
  const csv = button(say('profile.csv'), () =>
    download(new Blob([toCsv(samples, world)], { type: 'text/csv' }), kCsvName),
  );
  const results = element('div', {}, chart.element, facts, element('p', {}, csv));
  results.hidden = true;

  function read(isNew: boolean): void {
    const places = placesAlong(line.points);
    const hits = places.length === 0 ? [] : context.cast(raysDown(places, world));
    const now = makeSamples(places, hits, world);
    samples = isNew ? now : finest(samples, now);
    results.hidden = samples.length === 0;
    chart.show(samples);
    setFacts(facts, samples.length === 0 ? [] : factRows());
    context.changed();
  }

  function factRows(): (readonly [string, string])[] {
    const f = toFacts(samples);
    if (f === undefined) return [[say('profile.none'), ' ']];
    return [
      [say('profile.length'), numbers.length(f.lengthM)],
      [say('profile.lowest'), numbers.length(f.lowestM)],
      [say('profile.highest'), numbers.length(f.highestM)],
      [say('profile.ascent'), numbers.length(f.ascentM)],
      [say('profile.descent'), numbers.length(f.descentM)],
      [say('profile.voxel'), numbers.length(f.coarsestVoxelM)],
      [say('profile.exaggeration'), `${numbers.number(chart.exaggeration, 1)} ×`],
    ];
  }

  function shapes(): readonly (Shape | undefined)[] {
    const cursor = chart.cursor;
    const known = samples.filter((sample) => sample.heightM !== undefined);
    const surface = known.map((sample) => sample.point);
    const height = cursor?.heightM;
    return [
      surface.length > 1
        ? { kind: 'line', points: surface, tone: 'good' }
        : { kind: 'line', points: line.points, tone: 'usual' },
      ...line.marks,
      cursor === undefined || height === undefined
        ? undefined
        : { kind: 'point', at: cursor.point, tone: 'good', label: numbers.length(height) },
    ];
  }

  return {
    id: 'profile',
    panel: [...line.controls, results],
    begin: () => chart.resize(),
    ...line.tool,
    shapes: () => (line.points.length === 0 ? [] : shapes()),
    settled: () => {
      if (line.points.length > 1) read(false);
    },
  };
}
