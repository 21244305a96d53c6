import type { AnalysisLayer } from './analysis-layer.js';
import { messageOf } from './api.js';
import { colourOf, scaleOf, type ColourScale } from './colour-scale.js';
import { byId, element, setText } from './dom.js';
import type { Jobs } from './jobs.js';
import { levelFor, readBand, readRasterInfo, type RasterInfo } from './raster-file.js';

/** Cells that a browser shows at once: a coarser level of larger rasters is shown. */
const kShownCells = 2_000_000;
/** Bands whose values are numbers of something: no colours between them mean anything. */
const kHiddenBands = new Set(['class', 'material', 'red', 'green', 'blue', 'dtm_source']);

const kNames: Readonly<Record<string, string>> = {
  dsm: 'Height of what is highest',
  dtm: 'Height of the ground',
  ndsm: 'Height above the ground',
  slope: 'Slope',
  aspect: 'Where the slope falls to',
  hillshade: 'Hillshade',
  svf: 'Sky-view factor',
  sky_view_solid: 'Share of the sky that is seen',
  openness: 'Openness',
  sun_hours: 'Hours of sun',
  first_sun: 'First sun',
  last_sun: 'Last sun',
  sun_hours_per_day: 'Hours of sun a day',
  sun_share: 'Share of the time that the sun is up',
  kwh_m2: 'Energy',
  beam: 'Energy from the sun',
  diffuse: 'Energy from the sky',
  reflected: 'Energy from around',
  seen: 'Seen',
  distance_m: 'Distance',
  hole: 'Data that could not be read',
};

const numberText = (value: number): string => String(Number(value.toPrecision(4)));
const withUnit = (value: number, unit: string): string => (unit === '' ? numberText(value) : `${numberText(value)} ${unit}`);

/** Shows the raster of a finished job: band, legend, opacity, value, download. */
export class AnalysisResult {
  readonly #jobs: Jobs;
  readonly #layer: AnalysisLayer;
  readonly #part = byId('analysis-result', HTMLElement);
  readonly #band = element('select', { id: 'analysis-band' });
  readonly #legend = element('canvas', { width: '256', height: '14', role: 'img' });
  readonly #ends = element('p', { class: 'ends' });
  readonly #value = element('p', { id: 'analysis-value' });
  readonly #note = element('p', { class: 'note', role: 'status' });
  #id = '';
  #info: RasterInfo | undefined;
  #unit = '';
  #turn = 0;

  constructor(jobs: Jobs, layer: AnalysisLayer, onDelete: () => void) {
    this.#jobs = jobs;
    this.#layer = layer;
    const opacity = element('input', { id: 'analysis-opacity', type: 'range', min: '0', max: '100', value: '70' });
    opacity.addEventListener('input', () => (layer.opacity = Number(opacity.value) / 100));
    this.#band.addEventListener('change', () => void this.#showBand());
    const download = element('button', { type: 'button' }, 'Download GeoTIFF');
    download.addEventListener('click', () => void this.#download());
    const remove = element('button', { type: 'button' }, 'Remove');
    remove.addEventListener('click', onDelete);
    this.#part.replaceChildren(
      element('p', {}, element('label', { for: 'analysis-band' }, 'Shown'), this.#band),
      this.#legend,
      this.#ends,
      this.#value,
      element('p', {}, element('label', { for: 'analysis-opacity' }, 'Opacity'), opacity),
      element('p', { class: 'buttons' }, download, remove),
      this.#note,
    );
  }

  async show(id: string, hasHoles: boolean): Promise<void> {
    this.#id = id;
    this.#info = await readRasterInfo((offset, length) => this.#jobs.read(id, offset, length));
    this.#band.replaceChildren();
    this.#info.bands.forEach(({ name }, i) => {
      if (!kHiddenBands.has(name) && (name !== 'hole' || hasHoles)) this.#band.append(element('option', { value: String(i) }, kNames[name] ?? name));
    });
    setText(this.#note, hasHoles ? 'Some data could not be read: cells without colour have no value.' : '');
    this.#part.hidden = false;
    await this.#showBand();
  }

  hide(): void {
    ++this.#turn;
    this.#part.hidden = true;
    this.#info = undefined;
    this.#layer.clear();
  }

  /** The pointer is over this place, or in the middle of the map. */
  pointAt(easting: number, northing: number): void {
    if (this.#info === undefined) return;
    const value = this.#layer.valueAt(easting, northing);
    setText(this.#value, value === undefined ? 'Here: no value' : `Here: ${withUnit(value, this.#unit)}`);
  }

  async #showBand(): Promise<void> {
    const [info, id, turn] = [this.#info, this.#id, ++this.#turn];
    if (info === undefined) return;
    const number = Number(this.#band.value);
    const level = levelFor(info, kShownCells);
    try {
      const values = await readBand((offset, length) => this.#jobs.read(id, offset, length), info, level, number);
      if (turn !== this.#turn) return;
      const scale = scaleOf(values, info.noData);
      this.#unit = info.bands[number]?.unit ?? '';
      this.#drawLegend(scale);
      if (scale) this.#layer.show({ info, level, values, scale });
      else this.#layer.clear();
    } catch (error) {
      if (turn === this.#turn) setText(this.#note, `The raster could not be shown. ${messageOf(error)}`);
    }
  }

  #drawLegend(scale: ColourScale | undefined): void {
    this.#legend.hidden = scale === undefined;
    if (scale === undefined) return setText(this.#ends, 'No cell has a value.');
    const [least, most] = [withUnit(scale.min, this.#unit), withUnit(scale.max, this.#unit)];
    this.#ends.replaceChildren(element('span', {}, least), element('span', {}, most));
    this.#legend.setAttribute('aria-label', `Colours from ${least}, dark, to ${most}`);
    const context = this.#legend.getContext('2d');
    for (let x = 0; x < 256 && context !== null; ++x) {
      context.fillStyle = `rgb(${colourOf(x / 255, { min: 0, max: 1 }).join(' ')})`;
      context.fillRect(x, 0, 1, 14);
    }
  }

  async #download(): Promise<void> {
    try {
      const url = URL.createObjectURL(await this.#jobs.file(this.#id));
      const link = element('a', { href: url, download: 'terravox.tif' });
      link.click();
      setTimeout(() => URL.revokeObjectURL(url), 60_000);
    } catch (error) {
      setText(this.#note, `The file could not be fetched. ${messageOf(error)}`);
    }
  }
}
