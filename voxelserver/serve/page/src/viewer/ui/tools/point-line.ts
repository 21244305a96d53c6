/** Points that people click one after another, and the buttons that go with them. */
import { button, buttonRow, element, setText } from '../../../dom.js';
import type { Vec3 } from '../../../vec3.js';
import { kMaxPoints } from '../link.js';
import type { ToolContext } from '../tool.js';
import { makeNote, middleButton } from '../widgets.js';

export type PointLine = {
  readonly points: readonly Vec3[];
  readonly controls: readonly HTMLElement[];
  add(point: Vec3): void;
  set(points: readonly Vec3[]): void;
};

/** @param onChange after each change, also by set() */
export function makePointLine(context: ToolContext, onChange: () => void): PointLine {
  const { say } = context;
  let points: readonly Vec3[] = [];
  const note = makeNote();
  const set = (next: readonly Vec3[]): void => {
    points = next;
    setText(note, '');
    onChange();
  };
  const add = (point: Vec3): void => {
    if (points.length >= kMaxPoints) setText(note, say('tooManyPoints', String(kMaxPoints)));
    else set([...points, point]);
  };
  return {
    get points() {
      return points;
    },
    controls: [
      element('p', { class: 'hint' }, say('addMiddleHint')),
      buttonRow(
        middleButton(say('addMiddle'), context, note, add),
        button(say('undo'), () => set(points.slice(0, -1))),
        button(say('clear'), () => set([])),
      ),
      note,
    ],
    add,
    set,
  };
}
