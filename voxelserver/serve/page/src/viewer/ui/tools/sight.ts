/** What an observer sees: shades the rest, and says what is in the way to a target. */
import { button, buttonRow, element, setFacts, setText } from '../../../dom.js';
import type { Vec3 } from '../../../vec3.js';
import { numbers as readNumbers, numbersWord, readPoint } from '../link.js';
import type { Shape } from '../overlay.js';
import { toSight, sightRay, type Sight } from '../sight-line.js';
import type { Tool, ToolContext } from '../tool.js';
import { checkbox, makeNote, middleButton, numberField, select } from '../widgets.js';

type Setting = 'observer' | 'target';

type State = {
  /** On the ground. */
  readonly observer: Vec3 | undefined;
  readonly target: Vec3 | undefined;
  readonly eyeM: number;
  readonly isShaded: boolean;
};

const kEyeM = 1.7;
const kMaxEyeM = 1000;
const kNothing = { observer: undefined, target: undefined, eyeM: kEyeM, isShaded: true } as const;

export function makeSight(context: ToolContext): Tool {
  const { say, numbers, world } = context;
  let setting: Setting = 'observer';
  let observer: Vec3 | undefined;
  let target: Vec3 | undefined;
  let eyeM = kEyeM;
  let sight: Sight | undefined;
  const result = element('p', { id: 'sight', role: 'status' });
  const facts = element('dl', {});
  const note = makeNote();
  const sets = select<Setting>(
    say('sight.sets'),
    [
      ['observer', say('sight.observer')],
      ['target', say('sight.target')],
    ],
    (to) => (setting = to),
  );
  const eye = numberField(say('sight.eye'), { min: 0, max: kMaxEyeM, step: 0.1 }, () => {
    const value = eye.input.valueAsNumber;
    if (value >= 0 && value <= kMaxEyeM) eyeM = value;
    else eye.input.valueAsNumber = eyeM;
    changed();
  });
  const shade = checkbox(say('sight.shade'), true, () => changed());

  function eyeAt(): Vec3 | undefined {
    if (observer === undefined) return undefined;
    return [observer[0], observer[1] + eyeM / world.voxelM, observer[2]];
  }

  function changed(): void {
    setText(note, '');
    look();
    context.lookChanged();
  }

  function look(): void {
    const from = eyeAt();
    const ray = from === undefined || target === undefined ? undefined : sightRay(from, target);
    sight = ray === undefined ? undefined : toSight(ray, context.cast([ray])[0]);
    setText(result, sight === undefined ? '' : sentence(sight));
    setFacts(facts, sight === undefined ? [] : toFacts(sight));
  }

  function sentence({ obstacle, obstacleDistance }: Sight): string {
    if (obstacle === undefined) return say('sight.clear');
    return say('sight.blocked', numbers.length(obstacleDistance * world.voxelM));
  }

  function toFacts({ distance, obstacle }: Sight): (readonly [string, string])[] {
    const [x, y, z] = obstacle ?? [0, 0, 0];
    const units = world.unitsPerVoxel;
    const place = `${numbers.number(x * units, 1)}; ${numbers.number(-z * units, 1)}`;
    return [
      [say('sight.distance'), numbers.length(distance * world.voxelM)],
      [say('sight.obstacle'), obstacle === undefined ? '' : place],
      [say('height'), obstacle === undefined ? '' : numbers.length(y * world.voxelM)],
    ];
  }

  function put(point: Vec3): void {
    if (setting === 'observer') {
      observer = point;
      // The next click is for what the observer may see.
      setting = 'target';
      sets.input.value = setting;
    } else target = point;
    changed();
  }

  function set(next: State): void {
    ({ observer, target, eyeM } = next);
    eye.input.valueAsNumber = eyeM;
    shade.input.checked = next.isShaded;
    setting = observer === undefined ? 'observer' : 'target';
    sets.input.value = setting;
    changed();
  }

  function shapes(): readonly (Shape | undefined)[] {
    const from = eyeAt();
    if (from === undefined || observer === undefined) return [];
    const stand: Shape[] = [
      { kind: 'line', points: [observer, from], tone: 'usual' },
      { kind: 'point', at: from, tone: 'usual', label: say('sight.eyeLabel') },
    ];
    if (target === undefined) return stand;
    const at = sight?.obstacle;
    const tone = at === undefined ? 'good' : 'bad';
    return [
      { kind: 'line', points: [from, at ?? target], tone: 'good' },
      at && { kind: 'line', points: [at, target], tone },
      ...stand,
      { kind: 'point', at: target, tone, label: say('sight.targetLabel') },
      at && { kind: 'point', at, tone, label: say('sight.obstacle') },
    ];
  }

  eye.input.valueAsNumber = eyeM;
  return {
    id: 'sight',
    panel: [
      element('p', { class: 'hint' }, say('sight.hint')),
      sets.row,
      eye.row,
      shade.row,
      buttonRow(
        middleButton(say('sight.middle'), context, note, put),
        button(say('clear'), () => set(kNothing)),
      ),
      note,
      result,
      facts,
    ],
    click: ({ point }) => put(point),
    clear: () => set(kNothing),
    shapes,
    look: (before) => ({ ...before, observer: shade.input.checked ? eyeAt() : undefined }),
    settled: () => {
      if (target === undefined) return;
      look();
      context.changed();
    },
    words: () => ({
      observer: observer && numbersWord([...observer, eyeM]),
      target: target && numbersWord(target),
      shade: shade.input.checked ? undefined : '0',
    }),
    follow: (words) => {
      const from = readObserver(words.get('observer'));
      const target = readPoint(words.get('target'));
      set({ ...from, target, isShaded: words.get('shade') !== '0' });
    },
  };
}

function readObserver(word: string | null): Pick<State, 'observer' | 'eyeM'> {
  const parts = word?.split(',') ?? [];
  const observer = readPoint(parts.slice(0, 3).join(','));
  const eye = readNumbers(parts.slice(3).join(','), [[0, kMaxEyeM]]);
  return observer === undefined || eye === undefined ? kNothing : { observer, eyeM: eye[0]! };
}
