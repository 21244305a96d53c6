import type { Vec2 } from './vec3.js';
import { buttonRow, byId, element, setText, toOptions } from './dom.js';
import {
  countCells,
  daysOfPeriod,
  hasDays,
  hasSurface,
  kMaxDays,
  resolutionFor,
  type Kind,
  type Wish,
} from './jobs.js';
import { formatCount } from './number-format.js';
import type { Stats } from './replies.js';

const kNames: Readonly<Record<Kind, string>> = {
  terrain: 'Terrain: heights, slopes',
  sky: 'How much sky is seen',
  sun: 'Hours of sun',
  energy: 'Energy of the sun',
  sight: 'Seen from a place',
  clearance: 'Free height above the ground',
};
const kSurfaces: Readonly<Record<Wish['surface'], string>> = {
  top: 'roofs and crowns',
  ground: 'ground below them',
};
/** A raster that is made within a minute or so. */
const kUsualCells = 250_000;

export type JobLimits = NonNullable<Stats['jobs']>;

/** What the form needs to know of the map. */
export type FormPlace = {
  /**
   * West, south, east, north of what the map shows and the world has, CRS units; undefined:
   * nothing.
   */
  readonly extent: readonly number[] | undefined;
  readonly voxelM: number;
  readonly metresPerUnit: number;
  /** Hours that the clocks of its analyses are ahead of UTC; undefined: nobody knows. */
  readonly clockOffsetH: number | undefined;
  /** The place that was picked last. */
  readonly picked: Vec2 | undefined;
};

// Sweden writes days as ISO 8601 does.
const today = (): string => new Date().toLocaleDateString('sv-SE');

const dayInput = (id: string): HTMLInputElement =>
  element('input', { id, type: 'date', min: '1900-01-01', max: '2100-12-31', required: '' });

const row = (label: string, field: HTMLElement): HTMLElement =>
  element('p', {}, element('label', { for: field.id }, label), field);

const kDay = new Intl.DateTimeFormat('en-GB', { dateStyle: 'medium', timeZone: 'UTC' });
const dayText = (day: string): string => kDay.format(new Date(day));

/** What a result is of: by the time that it is shown the form may say something else. */
export function toCaption({ kind, surface, from, to, resolutionM, clockOffsetH }: Wish): string {
  const parts: string[] = [kNames[kind]];
  if (hasSurface(kind)) parts.push(kSurfaces[surface]);
  if (hasDays(kind)) parts.push(from === to ? dayText(from) : `${dayText(from)} to ${dayText(to)}`);
  parts.push(`cells of ${resolutionM} m`);
  const sentences = [`${parts.join(' · ')}.`];
  if (hasDays(kind)) sentences.push('The sky has no clouds: this is an upper limit.');
  if (kind === 'sun' && from === to && clockOffsetH !== undefined) {
    sentences.push(`Clock times are those of UTC${clockOffsetH < 0 ? '' : '+'}${clockOffsetH}.`);
  }
  return sentences.join(' ');
}

/** The fields by which an analysis is chosen. */
export class AnalysisForm {
  readonly #kind = element('select', { id: 'analysis-kind' });
  readonly #surface = element('select', { id: 'analysis-surface' });
  readonly #from = dayInput('analysis-from');
  readonly #to = dayInput('analysis-to');
  readonly #above = element('input', {
    id: 'analysis-above',
    type: 'number',
    min: '0',
    max: '10000',
    step: 'any',
    value: '1.6',
    required: '',
  });
  readonly #resolution = element('input', {
    id: 'analysis-resolution',
    type: 'number',
    min: '0.01',
    max: '100000',
    step: 'any',
    required: '',
  });
  readonly #cells = element('p', { class: 'note', id: 'analysis-cells' });
  readonly #submit = element('button', { type: 'submit' }, 'Compute what the map shows');
  readonly #rows: {
    readonly surface: HTMLElement;
    readonly days: HTMLElement;
    readonly observer: HTMLElement;
  };
  readonly #limits: JobLimits;
  #place: FormPlace | undefined;
  #hasOwnResolution = false;

  /** @param onWish called with what the user asks for, or with the reason why that cannot be */
  constructor(limits: JobLimits, kinds: readonly Kind[], onWish: (wish: Wish | string) => void) {
    this.#limits = limits;
    this.#kind.append(...toOptions(kinds.map((kind) => [kind, kNames[kind]])));
    if (kinds.includes('sun')) this.#kind.value = 'sun';
    this.#surface.append(...toOptions(Object.entries(kSurfaces)));
    for (const day of [this.#from, this.#to]) day.value = today();
    const days = element('div', {}, row('First day', this.#from), row('Last day', this.#to));
    const observer = element('div', {}, row('Eyes, metres above the marked place', this.#above));
    this.#rows = { surface: row('On', this.#surface), days, observer };
    const form = byId('analysis-form', HTMLFormElement);
    form.replaceChildren(
      row('Analysis', this.#kind),
      this.#rows.surface,
      days,
      observer,
      row('Edge of a cell, metres', this.#resolution),
      this.#cells,
      buttonRow(this.#submit),
    );
    form.addEventListener('submit', (event) => {
      event.preventDefault();
      onWish(this.#wish());
    });
    this.#kind.addEventListener('change', () => this.#showRows());
    this.#resolution.addEventListener('input', () => {
      this.#hasOwnResolution = this.#resolution.value !== '';
      this.#showCells();
    });
    this.#showRows();
  }

  /** The map shows something else, or another place was picked. */
  set place(place: FormPlace) {
    this.#place = place;
    const { extent, voxelM, metresPerUnit } = place;
    if (!this.#hasOwnResolution && extent) {
      const most = Math.min(this.#limits.maxCells, kUsualCells);
      this.#resolution.value = String(
        Number(resolutionFor(extent, voxelM, metresPerUnit, most).toPrecision(6)),
      );
    }
    this.#showCells();
  }

  set isBusy(busy: boolean) {
    this.#submit.disabled = busy;
  }

  #showRows(): void {
    const kind = this.#kind.value as Kind;
    this.#rows.surface.hidden = !hasSurface(kind);
    this.#rows.days.hidden = !hasDays(kind);
    for (const day of [this.#from, this.#to]) day.disabled = !hasDays(kind);
    this.#rows.observer.hidden = kind !== 'sight';
    this.#above.disabled = kind !== 'sight';
  }

  #showCells(): void {
    const extent = this.#place?.extent;
    const edge = Number(this.#resolution.value);
    if (extent === undefined || !(edge > 0)) {
      return setText(
        this.#cells,
        extent === undefined ? 'The map shows nothing of the world.' : '',
      );
    }
    const [columns, rows] = countCells(extent, edge, this.#place!.metresPerUnit);
    const { maxCells } = this.#limits;
    const allowed = `; this server computes up to ${formatCount(maxCells)}`;
    const most = columns * rows > maxCells ? `${allowed}: zoom in, or choose larger cells` : '';
    setText(this.#cells, `About ${formatCount(columns)} × ${formatCount(rows)} cells${most}.`);
  }

  #wish(): Wish | string {
    const place = this.#place;
    const kind = this.#kind.value as Kind;
    const resolutionM = Number(this.#resolution.value);
    if (place?.extent === undefined) {
      return 'The map shows nothing of the world: move it to where there is land.';
    }
    if (resolutionM < place.voxelM) {
      return `Cells are at least as large as a voxel: ${place.voxelM} m.`;
    }
    if (hasDays(kind) && this.#from.value > this.#to.value) {
      return 'The last day lies before the first one.';
    }
    if (hasDays(kind) && daysOfPeriod(this.#from.value, this.#to.value) > kMaxDays) {
      return `From the first to the last day are up to ${formatCount(kMaxDays)} days.`;
    }
    if (kind === 'sight' && place.picked === undefined) {
      return 'Click the map where somebody stands who looks around.';
    }
    const observer = place.picked && ([...place.picked, Number(this.#above.value)] as const);
    return {
      kind,
      extent: place.extent,
      resolutionM,
      surface: this.#surface.value === 'ground' ? 'ground' : 'top',
      from: this.#from.value,
      to: this.#to.value,
      clockOffsetH: place.clockOffsetH,
      observer,
    };
  }
}
