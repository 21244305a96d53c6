/**
 * The chart of a height profile. It is a slider along the line, for pointers and for arrow keys,
 * and says in words what it shows at each place.
 */
import { type Vec2, clamp } from '../../vec3.js';
import { element, setText, svgElement } from '../../dom.js';
import type { NumberText } from './number-text.js';
import { chooseTicks, type ProfileSample } from './profile-line.js';
import type { Say } from './texts.js';

export type ProfileChart = {
  readonly element: HTMLElement;
  /** Where the reader is on the line. */
  readonly cursor: ProfileSample | undefined;
  /** How many times larger heights are drawn than distances. */
  readonly exaggeration: number;
  show(samples: readonly ProfileSample[]): void;
  /** The chart may have been shown, and so have got another size. */
  resize(): void;
};

type Frame = {
  readonly width: number;
  readonly height: number;
  readonly lengthM: number;
  readonly fromM: number;
  readonly toM: number;
};

const kMargin = { left: 46, right: 14, top: 8, bottom: 20 } as const;
const kMinHeightsM = 1; // a flat line needs some range
const kPage = 10; // samples that a page key moves by
const kTickPx = { x: 70, y: 28 } as const;

export function makeProfileChart(say: Say, numbers: NumberText, onMove: () => void): ProfileChart {
  const svg = svgElement('svg', { 'aria-hidden': 'true' });
  const readout = element('output', { class: 'readout' });
  const plot = element(
    'div',
    {
      class: 'plot',
      role: 'slider',
      tabindex: '0',
      'aria-label': say('profile.chart'),
      'aria-valuemin': '0',
    },
    svg,
  );
  const box = element('div', { class: 'chart' }, readout, plot);
  let samples: readonly ProfileSample[] = [];
  let at = 0;
  let frame: Frame | undefined;

  function moveTo(index: number): void {
    at = clamp(index, 0, Math.max(0, samples.length - 1));
    draw();
    onMove();
  }

  plot.addEventListener('keydown', (event) => {
    const to = keyTarget(event.key, at, samples.length - 1);
    if (to === undefined) return;
    event.preventDefault();
    moveTo(to);
  });
  for (const type of ['pointerdown', 'pointermove'] as const) {
    plot.addEventListener(type, (event) => {
      if (frame === undefined || samples.length === 0) return;
      const x = event.clientX - plot.getBoundingClientRect().left;
      const share = (x - kMargin.left) / (frame.width - kMargin.left - kMargin.right);
      moveTo(Math.round(share * (samples.length - 1)));
    });
  }
  new ResizeObserver(() => draw()).observe(plot);

  function draw(): void {
    frame = makeFrame(samples, plot.clientWidth, plot.clientHeight);
    svg.replaceChildren();
    const cursor = samples[at];
    if (frame === undefined || cursor === undefined) return;
    svg.setAttribute('viewBox', `0 0 ${frame.width} ${frame.height}`);
    svg.append(...axes(frame, numbers), ...curves(frame, samples), ...marker(frame, cursor));
    const where = numbers.length(cursor.distanceM);
    const words =
      cursor.heightM === undefined
        ? say('profile.gap', where)
        : say('profile.at', where, numbers.length(cursor.heightM));
    setText(readout, words);
    plot.setAttribute('aria-valuemax', String(samples.length - 1));
    plot.setAttribute('aria-valuenow', String(at));
    plot.setAttribute('aria-valuetext', words);
  }

  return {
    element: box,
    get cursor() {
      return samples[at];
    },
    get exaggeration() {
      if (frame === undefined) return 1;
      const perM = (frame.height - kMargin.top - kMargin.bottom) / (frame.toM - frame.fromM);
      return (perM * frame.lengthM) / (frame.width - kMargin.left - kMargin.right);
    },
    show(next) {
      if (next.length !== samples.length) at = 0;
      samples = next;
      draw();
    },
    resize: draw,
  };
}

const kKeySteps: Readonly<Record<string, number>> = {
  ...{ ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 },
  ...{ PageUp: kPage, PageDown: -kPage, Home: -Infinity, End: Infinity },
};

/** Where a key leads to from a place, or undefined. */
export function keyTarget(key: string, at: number, last: number): number | undefined {
  const step = kKeySteps[key];
  return step === undefined ? undefined : clamp(at + step, 0, last);
}

function makeFrame(
  samples: readonly ProfileSample[],
  width: number,
  height: number,
): Frame | undefined {
  const heights = samples.map((s) => s.heightM).filter((h) => h !== undefined);
  const isDrawable = width > kMargin.left + kMargin.right && height > kMargin.top + kMargin.bottom;
  if (heights.length === 0 || !isDrawable) return undefined;
  const [low, high] = [Math.min(...heights), Math.max(...heights)];
  const missing = Math.max(0, kMinHeightsM - (high - low)) / 2;
  const room = (high - low) * 0.05 + missing;
  const lengthM = samples.at(-1)!.distanceM;
  return { width, height, lengthM, fromM: low - room, toM: high + room };
}

function toPixel(frame: Frame, distanceM: number, heightM: number): Vec2 {
  const { width, height, lengthM, fromM, toM } = frame;
  const x = kMargin.left + (distanceM / lengthM) * (width - kMargin.left - kMargin.right);
  const share = (heightM - fromM) / (toM - fromM);
  return [x, height - kMargin.bottom - share * (height - kMargin.top - kMargin.bottom)];
}

function axes(frame: Frame, numbers: NumberText): SVGElement[] {
  const { width, height, lengthM, fromM, toM } = frame;
  const out: SVGElement[] = [];
  const heights = chooseTicks(fromM, toM, Math.max(2, height / kTickPx.y));
  for (const h of heights) {
    const [, y] = toPixel(frame, 0, h);
    out.push(
      line('grid', [kMargin.left, y], [width - kMargin.right, y]),
      label(numbers.number(h, countDecimals(heights)), kMargin.left - 6, y + 4, 'end'),
    );
  }
  const distances = chooseTicks(0, lengthM, Math.max(2, width / kTickPx.x));
  for (const d of distances) {
    const [x] = toPixel(frame, d, fromM);
    const text = numbers.number(d, countDecimals(distances));
    out.push(
      line('grid', [x, kMargin.top], [x, height - kMargin.bottom]),
      label(text, x, height - 5, 'middle'),
    );
  }
  // In the corner, for both axes.
  return [...out, label('m', 2, height - 5, 'start')];
}

function countDecimals(ticks: readonly number[]): number {
  const step = ticks.length > 1 ? ticks[1]! - ticks[0]! : 1;
  return Math.min(3, Math.max(0, Math.ceil(-Math.log10(step) - 1e-9)));
}

// A curve for each run of places where something is known.
function curves(frame: Frame, samples: readonly ProfileSample[]): SVGElement[] {
  const runs: Vec2[][] = [[]];
  for (const { distanceM, heightM } of samples) {
    if (heightM === undefined) runs.push([]);
    else runs.at(-1)!.push(toPixel(frame, distanceM, heightM));
  }
  const bottom = frame.height - kMargin.bottom;
  return runs
    .filter((run) => run.length > 0)
    .flatMap((run) => {
      const points = run.map(([x, y]) => `${x.toFixed(1)},${y.toFixed(1)}`).join(' ');
      const [first, last] = [run[0]![0], run.at(-1)![0]];
      return [
        svgElement('polygon', {
          class: 'land',
          points: `${first},${bottom} ${points} ${last},${bottom}`,
        }),
        svgElement('polyline', { class: 'surface', points }),
      ];
    });
}

function marker(frame: Frame, { distanceM, heightM }: ProfileSample): SVGElement[] {
  const [x, y] = toPixel(frame, distanceM, heightM ?? frame.fromM);
  return [
    line('cursor', [x, kMargin.top], [x, frame.height - kMargin.bottom]),
    ...(heightM === undefined
      ? []
      : [svgElement('circle', { class: 'cursor', cx: x, cy: y, r: 4 })]),
  ];
}

function line(kind: string, [x1, y1]: Vec2, [x2, y2]: Vec2): SVGElement {
  return svgElement('line', { class: kind, x1, y1, x2, y2 });
}

function label(text: string, x: number, y: number, anchor: string): SVGElement {
  return svgElement('text', { x, y, 'text-anchor': anchor }, text);
}
