import type { Vec2 } from './vec3.js';
import { byId, setText, toOptions } from './dom.js';
import { countCells, resolutionFor, type Analysis, type Wish } from './jobs.js';
import { formatCount } from './number-format.js';
import type { Stats } from './replies.js';

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

const kDay = new Intl.DateTimeFormat('en-GB', { dateStyle: 'medium', timeZone: 'UTC' });
const dayText = (day: string): string => kDay.format(new Date(day));

/** What a result is of: by the time that it is shown the form may say something else. */
export function toCaption(wish: Wish): string {
  const { analysis, surface, from, to, resolutionM, clockOffsetH } = wish;
  const { kind, title, hasSurface, hasDays } = analysis;
  const parts: string[] = [title];
  if (hasSurface) parts.push(kSurfaces[surface]);
  if (hasDays) parts.push(from === to ? dayText(from) : `${dayText(from)} to ${dayText(to)}`);
  parts.push(`cells of ${resolutionM} m`);
  const sentences = [`${parts.join(' · ')}.`];
  if (hasDays) sentences.push('The sky has no clouds: this is an upper limit.');
  if (kind === 'sun' && from === to && clockOffsetH !== undefined) {
    sentences.push(`Clock times are those of UTC${clockOffsetH < 0 ? '' : '+'}${clockOffsetH}.`);
  }
  return sentences.join(' ');
}

/** The fields by which an analysis is chosen. */
export class AnalysisForm {
  readonly #kind = byId('analysis-kind', HTMLSelectElement);
  readonly #surface = byId('analysis-surface', HTMLSelectElement);
  readonly #from = byId('analysis-from', HTMLInputElement);
  readonly #to = byId('analysis-to', HTMLInputElement);
  readonly #resolution = byId('analysis-resolution', HTMLInputElement);
  readonly #limits: JobLimits;
  readonly #analyses: readonly Analysis[];
  #place: FormPlace | undefined;
  #hasOwnResolution = false;

  /**
   * @param isOnEarth elsewhere nobody knows where the sun is
   * @param onWish called with what the user asks for, or with the reason why that cannot be
   */
  constructor(limits: JobLimits, isOnEarth: boolean, onWish: (wish: Wish | string) => void) {
    this.#limits = limits;
    this.#analyses = limits.analyses.filter(({ hasDays }) => isOnEarth || !hasDays);
    this.#kind.append(...toOptions(this.#analyses.map(({ kind, title }) => [kind, title])));
    if (this.#analyses.some(({ kind }) => kind === 'sun')) this.#kind.value = 'sun';
    this.#surface.append(...toOptions(Object.entries(kSurfaces)));
    for (const day of [this.#from, this.#to]) day.value = today();
    const form = byId('analysis-form', HTMLFormElement);
    form.hidden = false;
    form.addEventListener('submit', (event) => {
      event.preventDefault();
      onWish(this.#wish());
    });
    this.#kind.addEventListener('change', () => this.#showFields());
    this.#from.addEventListener('change', () => (this.#to.min = this.#from.value));
    this.#resolution.addEventListener('input', () => {
      this.#hasOwnResolution = this.#resolution.value !== '';
      this.#showCells();
    });
    this.#showFields();
  }

  /** The map shows something else, or another place was picked. */
  set place(place: FormPlace) {
    this.#place = place;
    const { extent, voxelM, metresPerUnit } = place;
    this.#resolution.min = String(voxelM);
    if (!this.#hasOwnResolution && extent) {
      const most = Math.min(this.#limits.maxCells, kUsualCells);
      this.#resolution.value = String(
        Number(resolutionFor(extent, voxelM, metresPerUnit, most).toPrecision(6)),
      );
    }
    this.#showCells();
  }

  set isBusy(busy: boolean) {
    byId('analysis-submit', HTMLButtonElement).disabled = busy;
  }

  get #analysis(): Analysis | undefined {
    return this.#analyses.find(({ kind }) => kind === this.#kind.value);
  }

  #showFields(): void {
    const { hasSurface, hasDays, hasObserver } = this.#analysis ?? {};
    byId('analysis-on', HTMLElement).hidden = !hasSurface;
    const shown = { 'analysis-days': hasDays, 'analysis-observer': hasObserver };
    for (const [id, isShown] of Object.entries(shown)) {
      const fields = byId(id, HTMLFieldSetElement);
      fields.hidden = !isShown;
      // What is not shown does not have to be valid.
      fields.disabled = !isShown;
    }
  }

  #showCells(): void {
    const extent = this.#place?.extent;
    const edge = Number(this.#resolution.value);
    const cells = byId('analysis-cells', HTMLElement);
    if (extent === undefined) return setText(cells, 'The map shows nothing of the world.');
    if (!(edge > 0)) return setText(cells, '');
    const [columns, rows] = countCells(extent, edge, this.#place!.metresPerUnit);
    const { maxCells } = this.#limits;
    const allowed = `; this server computes up to ${formatCount(maxCells)}`;
    const most = columns * rows > maxCells ? `${allowed}: zoom in, or choose larger cells` : '';
    setText(cells, `About ${formatCount(columns)} × ${formatCount(rows)} cells${most}.`);
  }

  #wish(): Wish | string {
    const place = this.#place;
    const analysis = this.#analysis;
    if (analysis === undefined) return 'The server offers no analysis of this world.';
    if (place?.extent === undefined) {
      return 'The map shows nothing of the world: move it to where there is land.';
    }
    if (analysis.hasObserver && place.picked === undefined) {
      return 'Click the map where somebody stands who looks around.';
    }
    const aboveM = Number(byId('analysis-above', HTMLInputElement).value);
    return {
      analysis,
      extent: place.extent,
      resolutionM: Number(this.#resolution.value),
      surface: this.#surface.value === 'ground' ? 'ground' : 'top',
      from: this.#from.value,
      to: this.#to.value,
      clockOffsetH: place.clockOffsetH,
      observer: place.picked && [...place.picked, aboveM],
    };
  }
}
