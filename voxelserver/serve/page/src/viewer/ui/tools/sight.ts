/** What an observer sees: shades the rest, and says what is in the way to a target. */
import { button, buttonRow, element, setFacts, setText } from '../../../dom.js';
import type { Vec3 } from '../../../vec3.js';
import { numbers as readNumbers, numbersWord, readPoint } from '../link.js';
import type { Shape } from '../overlay.js';
import { toSight, sightRay, type Sight } from '../sight-line.js';
import type { Tool, ToolContext } from '../tool.js';
import { checkbox, makeNote, middleButton, numberField, select } from '../widgets.js';

type Setting = 'observer' | 'target';

const kEyeM = 1.7;
const kMaxEyeM = 1000;

export function makeSight(context: ToolContext): Tool {
  const { say, numbers, world } = context;
  let setting: Setting = 'observer';
  /** On the ground. */
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
    const units = world.unitsPerVoxel;
    const rows: (readonly [string, string])[] = [
      [say('sight.distance'), numbers.length(distance * world.voxelM)],
    ];
    if (obstacle === undefined) return rows;
    return [
      ...rows,
      [
        say('sight.obstacle'),
        `${numbers.number(obstacle[0] * units, 1)}; ${numbers.number(-obstacle[2] * units, 1)}`,
      ],
      [say('height'), numbers.length(obstacle[1] * world.voxelM)],
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

  function set(next: { observer?: Vec3; target?: Vec3; eyeM: number; isShaded: boolean }): void {
    ({ observer, target, eyeM } = { observer: undefined, target: undefined, ...next });
    eye.input.valueAsNumber = eyeM;
    shade.input.checked = next.isShaded;
    setting = observer === undefined ? 'observer' : 'target';
    sets.input.value = setting;
    changed();
  }

  function shapes(): readonly Shape[] {
    const from = eyeAt();
    if (from === undefined || observer === undefined) return [];
    const stand: Shape[] = [
      { kind: 'line', points: [observer, from], tone: 'usual' },
      { kind: 'point', at: from, tone: 'usual', label: say('sight.eyeLabel') },
    ];
    if (target === undefined) return stand;
    const isBlocked = sight?.obstacle !== undefined;
    const until = sight?.obstacle ?? target;
    return [
      { kind: 'line', points: [from, until], tone: 'good' },
      ...(isBlocked ? [{ kind: 'line', points: [until, target], tone: 'bad' } as const] : []),
      ...stand,
      {
        kind: 'point',
        at: target,
        tone: isBlocked ? 'bad' : 'good',
        label: say('sight.targetLabel'),
      },
      ...(isBlocked
        ? [{ kind: 'point', at: until, tone: 'bad', label: say('sight.obstacle') } as const]
        : []),
    ];
  }

  const nothing = { eyeM: kEyeM, isShaded: true };
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
        button(say('clear'), () => set(nothing)),
      ),
      note,
      result,
      facts,
    ],
    click: ({ point }) => put(point),
    clear: () => set(nothing),
    shapes,
    look: (before) => ({ ...before, observer: shade.input.checked ? eyeAt() : undefined }),
    settled: () => {
      if (target === undefined) return;
      look();
      context.changed();
    },
    words: () => ({
      ...(observer === undefined ? {} : { observer: numbersWord([...observer, eyeM]) }),
      ...(target === undefined ? {} : { target: numbersWord(target) }),
      ...(shade.input.checked ? {} : { shade: '0' }),
    }),
    follow: (words) => {
      const at = readObserver(words.get('observer'));
      const to = readPoint(words.get('target'));
      set({
        ...(at === undefined ? { eyeM: kEyeM } : { observer: at.point, eyeM: at.eyeM }),
        ...(to === undefined ? {} : { target: to }),
        isShaded: words.get('shade') !== '0',
      });
    },
  };
}

function readObserver(word: string | null): { point: Vec3; eyeM: number } | undefined {
  const parts = word?.split(',') ?? [];
  const point = readPoint(parts.slice(0, 3).join(','));
  const eye = readNumbers(parts.slice(3).join(','), [[0, kMaxEyeM]]);
  return point === undefined || eye === undefined ? undefined : { point, eyeM: eye[0]! };
}
