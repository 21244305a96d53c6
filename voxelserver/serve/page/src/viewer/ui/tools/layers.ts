/** What colours show: the true picture, or heights, materials, classes, levels; with a legend. */
import { type Vec2, along, normalized, type Vec3 } from '../../../vec3.js';
import { button, buttonRow, element, setText, svgElement } from '../../../dom.js';
import { heightColour, makeLegend, type Layer, type LegendEntry } from '../../draw/layers.js';
import type { CastRay } from '../../stage.js';
import { numbers as readNumbers, numbersWord } from '../link.js';
import { className, materialName } from '../texts.js';
import type { Tool, ToolContext } from '../tool.js';
import { makeNote, numberField, select } from '../widgets.js';

const kRampSteps = 32;
const kGrid = [24, 16] as const; // rays that look for the heights of a view
const kFarthestM = 1e6;
const kLayers: readonly Layer[] = ['none', 'height', 'material', 'class', 'level'];

export function makeLayers(context: ToolContext): Tool {
  const { say, numbers, world, appearance } = context;
  const whole: Vec2 = [
    Math.floor(world.framed.min[1] * world.voxelM),
    Math.ceil(world.framed.max[1] * world.voxelM),
  ];
  let layer: Layer = 'none';
  let rangeM = whole;
  const note = makeNote();
  const legend = element('ul', { class: 'legend', 'aria-label': say('layer.legend') });
  const chosen = select<Layer>(
    say('layer.select'),
    kLayers.map((id) => [id, say(`layer.${id}`)] as const),
    (to) => set(to, rangeM),
  );
  const limits = { min: -kFarthestM, max: kFarthestM, step: 1 };
  const from = numberField(say('layer.from'), limits, rangeChanged);
  const to = numberField(say('layer.to'), limits, rangeChanged);
  const fit = buttonRow(button(say('layer.fit'), fitToView));
  const rangeRows = element('div', {}, from.row, to.row, fit);

  function set(next: Layer, range: Vec2): void {
    layer = next;
    rangeM = range;
    chosen.input.value = layer;
    from.input.valueAsNumber = rangeM[0];
    to.input.valueAsNumber = rangeM[1];
    rangeRows.hidden = layer !== 'height';
    setText(note, '');
    legend.replaceChildren(...(layer === 'height' ? [ramp()] : entries()));
    context.lookChanged();
  }

  function rangeChanged(): void {
    const range = [from.input.valueAsNumber, to.input.valueAsNumber] as const;
    if (isRange(range)) set(layer, range);
    else setText(note, say('layer.wrongRange'));
  }

  function fitToView(): void {
    const heights = context
      .cast(raysOfView())
      .filter((hit) => hit !== undefined)
      .map((hit) => hit.point[1] * world.voxelM);
    if (heights.length === 0) {
      setText(note, say('nothingThere'));
      return;
    }
    const low = Math.floor(Math.min(...heights));
    set(layer, [low, Math.max(low + 1, Math.ceil(Math.max(...heights)))]);
  }

  function raysOfView(): CastRay[] {
    const { position, forward, right, up } = context.camera();
    const [columns, rows] = kGrid;
    return Array.from({ length: columns * rows }, (_, i) => {
      const across = (((i % columns) + 0.5) / columns) * 2 - 1;
      const upward = ((Math.floor(i / columns) + 0.5) / rows) * 2 - 1;
      const direction = normalized(
        along(forward, [right, across * context.aspect()], [up, upward]),
      );
      return { origin: position, direction, maxT: 2 ** 30 };
    });
  }

  function ramp(): HTMLElement {
    const colours = Array.from({ length: kRampSteps }, (_, i) =>
      heightColour((i + 0.5) / kRampSteps),
    );
    const ends = rangeM.map((m) => element('span', {}, `${numbers.number(m, 0)} m`));
    const middle = element('span', {}, `${numbers.number((rangeM[0] + rangeM[1]) / 2, 0)} m`);
    const scale = element('span', { class: 'ends' }, ends[0]!, middle, ends[1]!);
    return element('li', { class: 'ramp' }, swatches(colours), scale);
  }

  function entries(): HTMLElement[] {
    return makeLegend(layer, appearance, world.voxelM, world.levels).map((entry) =>
      element('li', {}, swatches([entry.colour]), element('span', {}, toName(entry))),
    );
  }

  function toName({ of }: LegendEntry): string {
    if (typeof of === 'string') return materialName(say, of);
    if (layer === 'class') return className(say, of);
    return `${numbers.number(of, String(of).split('.')[1]?.length ?? 0)} m`;
  }

  set('none', whole);
  return {
    id: 'layers',
    panel: [chosen.row, rangeRows, note, legend],
    clear: () => set('none', whole),
    shapes: () => [],
    look: (look) => ({
      ...look,
      layer,
      heightRange: [rangeM[0] / world.voxelM, rangeM[1] / world.voxelM],
    }),
    words: () => ({
      layer: layer === 'none' ? undefined : layer,
      range: layer === 'none' || rangeM.join() === whole.join() ? undefined : numbersWord(rangeM),
    }),
    follow: (words) => {
      const found = kLayers.find((id) => id === words.get('layer')) ?? 'none';
      const limit = [-kFarthestM, kFarthestM] as const;
      const range = readNumbers(words.get('range'), [limit, limit]);
      const isUsable = range !== undefined && isRange([range[0]!, range[1]!]);
      set(found, isUsable ? [range[0]!, range[1]!] : whole);
    },
  };
}

function isRange([from, to]: Vec2): boolean {
  return from < to && Math.abs(from) <= kFarthestM && Math.abs(to) <= kFarthestM;
}

function swatches(colours: readonly Vec3[]): SVGElement {
  const rects = colours.map((colour, x) =>
    svgElement('rect', { x, y: 0, width: 1.05, height: 1, fill: `rgb(${colour.join(' ')})` }),
  );
  const viewBox = `0 0 ${colours.length} 1`;
  const drawn = { viewBox, preserveAspectRatio: 'none', 'aria-hidden': 'true' };
  return svgElement('svg', drawn, ...rects);
}
