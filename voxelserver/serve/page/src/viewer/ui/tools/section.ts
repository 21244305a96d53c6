/** A plane that cuts the picture open. */
import { button, buttonRow, setText } from '../../../dom.js';
import { halfway } from '../../../vec3.js';
import {
  readSection,
  toSection,
  sectionWord,
  through,
  type SectionPlane,
} from '../section-plane.js';
import type { Tool, ToolContext } from '../tool.js';
import { makeNote, middleButton, select, slider } from '../widgets.js';

export function makeSection(context: ToolContext): Tool {
  const { say, numbers, world } = context;
  const { min, max } = world.framed;
  const pivot = halfway(min, max);
  const none: SectionPlane = {
    kind: 'off',
    azimuthDeg: 0,
    position: 0,
    height: pivot[1],
    isFlipped: false,
  };
  let plane = none;
  const note = makeNote();
  const kind = select(
    say('section.kind'),
    [
      ['off', say('section.off')],
      ['vertical', say('section.vertical')],
      ['horizontal', say('section.horizontal')],
    ],
    (to) => choose(to),
  );
  const metres = (value: number): string => numbers.length(value * world.voxelM);
  const azimuth = slider(
    say('section.azimuth'),
    (value) => `${numbers.number(value, 0)}°`,
    (azimuthDeg) => set({ ...plane, azimuthDeg }),
  );
  azimuth.setRange(0, 359, 1);
  const position = slider(say('section.position'), metres, (to) => set({ ...plane, position: to }));
  const reach = Math.ceil(Math.hypot(max[0] - min[0], max[2] - min[2]) / 2);
  position.setRange(-reach, reach, 1);
  const height = slider(say('section.height'), metres, (to) => set({ ...plane, height: to }));
  height.setRange(min[1], max[1], 1);
  const buttons = buttonRow(
    middleButton(say('section.middle'), context, note, (at) => set(through(plane, pivot, at))),
    button(say('section.flip'), () => set({ ...plane, isFlipped: !plane.isFlipped })),
  );

  function set(next: SectionPlane): void {
    plane = next;
    setText(note, '');
    kind.input.value = plane.kind;
    azimuth.value = plane.azimuthDeg;
    position.value = plane.position;
    height.value = plane.height;
    for (const row of [azimuth.row, position.row]) row.hidden = plane.kind !== 'vertical';
    height.row.hidden = plane.kind !== 'horizontal';
    buttons.hidden = plane.kind === 'off';
    context.lookChanged();
  }

  // What is nearest is in the way: an upright plane first cuts away what lies before the middle.
  function choose(to: SectionPlane['kind']): void {
    const [x, , z] = context.camera().forward;
    const azimuthDeg = Math.round((Math.atan2(-x, z) * 180) / Math.PI + 360) % 360;
    const seen = context.middle();
    const next: SectionPlane = { ...plane, kind: to, isFlipped: false, azimuthDeg };
    set(seen === undefined ? next : through(next, pivot, seen.point));
  }

  set(none);
  return {
    id: 'section',
    panel: [kind.row, azimuth.row, position.row, height.row, buttons, note],
    clear: () => set(none),
    shapes: () => [],
    look: (look) => ({ ...look, section: toSection(plane, pivot) }),
    words: () => ({ section: plane.kind === 'off' ? undefined : sectionWord(plane) }),
    follow: (words) => set(readSection(words.get('section'), none)),
  };
}
