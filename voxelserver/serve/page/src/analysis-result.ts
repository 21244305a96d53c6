import type { Vec2 } from './vec3.js';
import type { AnalysisLayer } from './analysis-layer.js';
import { toMessage } from './http/api.js';
import { colourlessText, chooseStyle, valueText, type BandStyle } from './band-styles.js';
import { toColour, chooseScale, type ColourScale } from './colour-scale.js';
import { button, buttonRow, byId, download, element, getContext2d, setText } from './dom.js';
import type { Jobs } from './jobs.js';
import { levelFor, readBand, readRasterInfo, type RasterInfo } from './raster-file.js';

/** Cells that a browser shows at once: a coarser level of larger rasters is shown. */
const kShownCells = 2_000_000;

/** A finished job, with what is written next to its raster. */
export type Finished = {
  readonly id: string;
  readonly hasHoles: boolean;
  readonly caption: string;
  readonly fileName: string;
};

/** Shows the raster of a finished job: band, legend, opacity, value, download. */
export class AnalysisResult {
  readonly #jobs: Jobs;
  readonly #layer: AnalysisLayer;
  readonly #part = byId('analysis-result', HTMLElement);
  readonly #caption = element('p', { id: 'analysis-caption' });
  readonly #band = element('select', { id: 'analysis-band' });
  readonly #legend = element('canvas', { width: '256', height: '14', role: 'img' });
  readonly #ends = element('p', { class: 'ends' });
  readonly #value = element('p', { id: 'analysis-value' });
  readonly #note = element('p', { class: 'note', role: 'status' });
  #id = '';
  #fileName = '';
  #hasHoles = false;
  #info: RasterInfo | undefined;
  #toText = String as (value: number) => string;
  /** The place whose value is shown. */
  #pointed: Vec2 | undefined;
  #turn = 0;

  constructor(jobs: Jobs, layer: AnalysisLayer, onDelete: () => void) {
    this.#jobs = jobs;
    this.#layer = layer;
    const opacity = element('input', {
      id: 'analysis-opacity',
      type: 'range',
      min: '0',
      max: '100',
      value: '100',
    });
    opacity.addEventListener('input', () => (layer.opacity = Number(opacity.value) / 100));
    this.#band.addEventListener('change', () => void this.#showBand());
    const save = button('Download GeoTIFF', () => void this.#download());
    const remove = button('Remove', onDelete);
    this.#part.replaceChildren(
      this.#caption,
      element('p', {}, element('label', { for: 'analysis-band' }, 'Shown'), this.#band),
      this.#legend,
      this.#ends,
      this.#value,
      element('p', {}, element('label', { for: 'analysis-opacity' }, 'Opacity'), opacity),
      buttonRow(save, remove),
      this.#note,
    );
  }

  async show({ id, hasHoles, caption, fileName }: Finished): Promise<void> {
    this.#id = id;
    this.#fileName = fileName;
    this.#hasHoles = hasHoles;
    this.#info = await readRasterInfo((offset, length) => this.#jobs.read(id, offset, length));
    this.#band.replaceChildren();
    this.#info.bands.forEach(({ name }, i) => {
      const style = chooseStyle(name);
      if (style && (name !== 'hole' || hasHoles)) {
        this.#band.append(element('option', { value: String(i) }, style.title));
      }
    });
    setText(this.#caption, caption);
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
    this.#pointed = [easting, northing];
    if (this.#info !== undefined) this.#showValue();
  }

  #showValue(): void {
    const value = this.#pointed && this.#layer.valueAt(...this.#pointed);
    setText(this.#value, value === undefined ? 'Here: no value' : `Here: ${this.#toText(value)}`);
  }

  /** The band that is chosen: its number, its unit, and how it is drawn. */
  #chosen({ bands }: RasterInfo): {
    readonly number: number;
    readonly unit: string;
    readonly style: BandStyle;
  } {
    const number = Number(this.#band.value);
    const { name, unit } = bands[number] ?? { name: '', unit: '' };
    return { number, unit, style: chooseStyle(name) ?? { title: name, ramp: 'much' } };
  }

  /** Says what has no colour, and before it what went wrong just now: neither hides the other. */
  #showNote(trouble = ''): void {
    const colourless = this.#info
      ? colourlessText(this.#chosen(this.#info).style, this.#hasHoles)
      : '';
    setText(this.#note, [trouble, colourless].filter((text) => text !== '').join(' '));
  }

  async #showBand(): Promise<void> {
    this.#turn += 1;
    const [info, id, turn] = [this.#info, this.#id, this.#turn];
    if (info === undefined) return;
    this.#showNote();
    const { number, unit, style } = this.#chosen(info);
    const level = levelFor(info, kShownCells);
    try {
      const values = await readBand(
        (offset, length) => this.#jobs.read(id, offset, length),
        info,
        level,
        number,
      );
      if (turn !== this.#turn) return;
      const scale = chooseScale(values, info.noData, style);
      if (scale) this.#toText = (value) => valueText(value, unit, style, scale);
      this.#drawLegend(scale, style);
      if (scale) this.#layer.show({ info, level, values, scale, style });
      else this.#layer.clear();
      this.#showValue();
    } catch (error) {
      if (turn !== this.#turn) return;
      // The band before must not look like the one that is chosen now.
      this.#layer.clear();
      this.#legend.hidden = true;
      this.#ends.replaceChildren();
      this.#showValue();
      this.#showNote(`The raster could not be shown. ${toMessage(error)}`);
    }
  }

  #drawLegend(scale: ColourScale | undefined, { ramp, words }: BandStyle): void {
    this.#legend.hidden = scale === undefined;
    if (scale === undefined) return setText(this.#ends, 'No cell has a value.');
    const middle = (scale.min + scale.max) / 2;
    const texts = words
      ? [words[1]]
      : [scale.min, middle, scale.max].map((value) => this.#toText(value));
    this.#ends.replaceChildren(...texts.map((text) => element('span', {}, text)));
    this.#legend.setAttribute(
      'aria-label',
      words ? `The colour of: ${words[1]}` : `Colours from ${texts[0]} to ${texts[2]}`,
    );
    const context = getContext2d(this.#legend);
    for (let x = 0; x < 256; ++x) {
      const colour = toColour(words ? 1 : x / 255, { min: 0, max: 1 }, ramp);
      context.fillStyle = `rgb(${colour.join(' ')})`;
      context.fillRect(x, 0, 1, 14);
    }
  }

  async #download(): Promise<void> {
    this.#showNote();
    try {
      download(await this.#jobs.file(this.#id), this.#fileName);
    } catch (error) {
      this.#showNote(`The file could not be fetched. ${toMessage(error)}`);
    }
  }
}
