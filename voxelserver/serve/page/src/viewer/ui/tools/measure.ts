/** Distances, heights, slopes and areas between clicked points. */
import { element, setFacts } from '../../../dom.js';
import { distance, halfway } from '../../../vec3.js';
import { measurePath } from '../measures.js';
import type { Shape } from '../overlay.js';
import type { Tool, ToolContext } from '../tool.js';
import { checkbox } from '../widgets.js';
import { makePointLine } from './point-line.js';

const kDegrees = 180 / Math.PI;

export function makeMeasure(context: ToolContext): Tool {
  const { say, numbers, world } = context;
  let isClosed = false;
  const results = element('dl', { id: 'measures', 'aria-live': 'polite' });
  const line = makePointLine(context, 'measure', changed);
  const closed = checkbox(say('measure.closed'), isClosed, (isOn) => {
    isClosed = isOn;
    changed();
  });

  function changed(): void {
    setFacts(results, facts());
    context.changed();
  }

  function facts(): (readonly [string, string])[] {
    const { points } = line;
    if (points.length < 2) return [[say('points'), String(points.length)]];
    const m = measurePath(points, world.voxelM);
    const degrees = Math.atan2(m.heightM, m.spanM) * kDegrees;
    const percent = m.spanM > 0 ? ` (${numbers.number((100 * m.heightM) / m.spanM, 1)} %)` : '';
    return [
      [say('points'), String(points.length)],
      [say('measure.slope'), numbers.length(m.slopeM)],
      [say('measure.horizontal'), numbers.length(m.horizontalM)],
      [say('measure.height'), numbers.length(m.heightM)],
      [say('measure.gradient'), `${numbers.number(degrees, 1)}°${percent}`],
      [
        say('measure.azimuth'),
        m.azimuthDeg === undefined ? '' : `${numbers.number(m.azimuthDeg, 1)}°`,
      ],
      [say('measure.area'), isArea() ? numbers.area(m.areaM2) : ''],
      [say('measure.perimeter'), isArea() ? numbers.length(m.perimeterM) : ''],
    ];
  }

  function isArea(): boolean {
    return isClosed && line.points.length >= 3;
  }

  function shapes(): readonly Shape[] {
    const { points } = line;
    const ring = isArea() ? [...points, points[0]!] : points;
    const labels = ring.slice(1).map((to, i): Shape => {
      const from = ring[i]!;
      const label = numbers.length(distance(from, to) * world.voxelM);
      return { kind: 'label', at: halfway(from, to), label };
    });
    return [{ kind: 'line', points: ring, tone: 'usual' }, ...line.marks, ...labels];
  }

  return {
    id: 'measure',
    panel: [...line.controls, closed.row, results],
    ...line.tool,
    shapes: () => (line.points.length === 0 ? [] : shapes()),
    words: () => ({ ...line.tool.words(), area: isClosed ? '1' : undefined }),
    follow: (words) => {
      isClosed = words.get('area') === '1';
      closed.input.checked = isClosed;
      line.tool.follow(words);
    },
  };
}
