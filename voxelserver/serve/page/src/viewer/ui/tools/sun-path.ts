/** The sun's way over the chosen day: over the picture, and its times in words. */
import { button, buttonRow, element, setFacts } from '../../../dom.js';
import { kNowhere, sunPosition } from '../../draw/sun-position.js';
import { towards, type Vec3 } from '../../../vec3.js';
import type { Shape } from '../overlay.js';
import { isUp, sunDay, type SunAt, type SunDay } from '../sun-day.js';
import type { Tool, ToolContext } from '../tool.js';
import { checkbox } from '../widgets.js';

const kMinuteMs = 60_000;
const kSunPx = 11;
const kHourPx = 4;

export function makeSunPath(context: ToolContext): Tool {
  const { say, numbers, world } = context;
  const place = world.centre ?? kNowhere;
  let day = sunDay(context.timeMs(), place);
  const facts = element('dl', { id: 'sun-facts' });
  const shown = checkbox(say('sun.show'), false, () => context.changed());

  function sunNow(): SunAt {
    const timeMs = context.timeMs();
    return { timeMs, ...sunPosition(timeMs, place) };
  }

  function timeChanged(): void {
    day = sunDay(context.timeMs(), place);
    setFacts(facts, toFacts(day));
  }

  function toFacts({ noon, rise, set }: SunDay): (readonly [string, string])[] {
    const high = numbers.number(noon.altitudeDeg, 1);
    const hasEdges = rise !== undefined && set !== undefined;
    return [
      [say('sun.rise'), edge(rise)],
      [say('sun.noon'), say('sun.noonValue', clock(noon.timeMs), high)],
      [say('sun.set'), edge(set)],
      hasEdges ? [say('sun.length'), length(rise, set)] : [withoutEdge(noon), ' '],
    ];
  }

  function length(rise: SunAt, set: SunAt): string {
    const minutes = Math.round(lengthMs(rise, set) / kMinuteMs);
    return say('sun.hours', ...[Math.floor(minutes / 60), minutes % 60].map(String));
  }

  function edge(at: SunAt | undefined): string {
    if (at === undefined) return '';
    return say('sun.edgeValue', clock(at.timeMs), numbers.number(at.azimuthDeg, 0));
  }

  function withoutEdge(noon: SunAt): string {
    return say(noon.altitudeDeg < 0 ? 'sun.noRise' : 'sun.noSet');
  }

  function shapes(): readonly Shape[] {
    const marked = [day.rise, day.noon, day.set].filter((at) => at !== undefined);
    return [
      ...findRuns(day.path).map((run): Shape => ({
        kind: 'sky-line',
        directions: run.map(toSun),
        tone: 'sun',
      })),
      ...marked.filter(isUp).map((at) => mark(at, clock(at.timeMs))),
      ...day.hours.filter(isUp).map((at) => mark(at, `${new Date(at.timeMs).getUTCHours()} h`)),
      { kind: 'sky-point', direction: toSun(sunNow()), tone: 'sun', radiusPx: kSunPx },
    ];
  }

  timeChanged();
  return {
    id: 'sun',
    panel: [
      shown.row,
      facts,
      buttonRow(
        button(say('sun.turn'), () => {
          const sun = sunNow();
          context.turnTo(sun.azimuthDeg, sun.altitudeDeg);
        }),
      ),
      element('p', { class: 'hint' }, say('sun.note')),
    ],
    begin: () => (shown.input.checked = true),
    clear: () => {
      shown.input.checked = false;
      context.changed();
    },
    shapes: () => (shown.input.checked ? shapes() : []),
    timeChanged,
    words: () => ({ sun: shown.input.checked ? '1' : undefined }),
    follow: (words) => {
      shown.input.checked = words.get('sun') === '1';
      context.changed();
    },
  };
}

const toSun = (at: SunAt): Vec3 => towards(at.azimuthDeg, at.altitudeDeg);

function mark(at: SunAt, label: string): Shape {
  return { kind: 'sky-point', direction: toSun(at), tone: 'sun', radiusPx: kHourPx, label };
}

// A day of the place begins at its midnight: where the sun does not set then, it rises after it.
function lengthMs(rise: SunAt, set: SunAt): number {
  const kDayMs = 86_400_000;
  const ms = set.timeMs - rise.timeMs;
  return ms < 0 ? ms + kDayMs : ms;
}

// Parts of the day while the sun is up.
function findRuns(path: readonly SunAt[]): SunAt[][] {
  const runs: SunAt[][] = [[]];
  for (const at of path) {
    if (isUp(at)) runs.at(-1)!.push(at);
    else if (runs.at(-1)!.length > 0) runs.push([]);
  }
  return runs;
}

function clock(timeMs: number): string {
  return new Date(Math.round(timeMs / kMinuteMs) * kMinuteMs).toISOString().slice(11, 16);
}
