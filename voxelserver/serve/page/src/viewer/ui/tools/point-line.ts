/** Points that people click one after another, and the buttons that go with them. */
import { button, buttonRow, element, setText } from '../../../dom.js';
import type { Vec3 } from '../../../vec3.js';
import { kMaxPoints, pointsWord, readPoints } from '../link.js';
import type { Shape } from '../overlay.js';
import type { Tool, ToolContext } from '../tool.js';
import { makeNote, middleButton } from '../widgets.js';

export type PointLine = {
  readonly points: readonly Vec3[];
  readonly controls: readonly HTMLElement[];
  /** The points themselves. */
  readonly marks: readonly Shape[];
  /** What a tool of points does. */
  readonly tool: Required<Pick<Tool, 'click' | 'clear' | 'words' | 'follow'>>;
};

/** @param word of the points in the link @param onChange after each change */
export function makePointLine(context: ToolContext, word: string, onChange: () => void): PointLine {
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
    get marks() {
      return points.map((at): Shape => ({ kind: 'point', at, tone: 'usual' }));
    },
    tool: {
      click: ({ point }) => add(point),
      clear: () => set([]),
      words: () => ({ [word]: points.length > 0 ? pointsWord(points) : undefined }),
      follow: (words) => set(readPoints(words.get(word))),
    },
  };
}
