import type { Vec2 } from './vec3.js';
import type { AnalysisLayer } from './analysis-layer.js';
import { toMessage } from './http/api.js';
import { colourlessText, chooseStyle, valueText, type BandStyle } from './band-styles.js';
import { toColour, chooseScale, type ColourScale } from './colour-scale.js';
import { button, buttonRow, byId, download, element, getContext2d, setText } from './dom.js';
import { openRaster, type Raster } from './raster.js';

/** The raster of a finished job, with what is written next to it. */
export type Finished = {
  readonly file: Blob;
  readonly hasHoles: boolean;
  readonly caption: string;
  readonly fileName: string;
};

/** Shows the raster of a job: band, legend, opacity, value, download. */
export class AnalysisResult {
  readonly #layer: AnalysisLayer;
  readonly #part = byId('analysis-result', HTMLElement);
  readonly #caption = element('p', { id: 'analysis-caption' });
  readonly #band = element('select', { id: 'analysis-band' });
  readonly #legend = element('canvas', { width: '256', height: '14', role: 'img' });
  readonly #ends = element('p', { class: 'ends' });
  readonly #value = element('p', { id: 'analysis-value' });
  readonly #note = element('p', { class: 'note', role: 'status' });
  #hasHoles = false;
  #raster: Raster | undefined;
  #save = (): void => undefined;
  #toText = String as (value: number) => string;
  /** The place whose value is shown. */
  #pointed: Vec2 | undefined;
  #turn = 0;

  constructor(layer: AnalysisLayer, onDelete: () => void) {
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
    const save = button('Download GeoTIFF', () => this.#save());
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

  async show({ file, hasHoles, caption, fileName }: Finished): Promise<void> {
    this.#hasHoles = hasHoles;
    this.#save = () => download(file, fileName);
    this.#raster = await openRaster(file);
    this.#band.replaceChildren();
    this.#raster.bands.forEach(({ name }, i) => {
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
    this.#raster = undefined;
    this.#layer.clear();
  }

  /** The pointer is over this place, or in the middle of the map. */
  pointAt(easting: number, northing: number): void {
    this.#pointed = [easting, northing];
    if (this.#raster !== undefined) this.#showValue();
  }

  #showValue(): void {
    const value = this.#pointed && this.#layer.valueAt(...this.#pointed);
    setText(this.#value, value === undefined ? 'Here: no value' : `Here: ${this.#toText(value)}`);
  }

  /** The band that is chosen: its number, its unit, and how it is drawn. */
  #chosen({ bands }: Raster): {
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
    const colourless = this.#raster
      ? colourlessText(this.#chosen(this.#raster).style, this.#hasHoles)
      : '';
    setText(this.#note, [trouble, colourless].filter((text) => text !== '').join(' '));
  }

  async #showBand(): Promise<void> {
    this.#turn += 1;
    const [raster, turn] = [this.#raster, this.#turn];
    if (raster === undefined) return;
    this.#showNote();
    const { number, unit, style } = this.#chosen(raster);
    try {
      const values = await raster.readBand(number);
      if (turn !== this.#turn) return;
      const scale = chooseScale(values, raster.noData, style);
      if (scale) this.#toText = (value) => valueText(value, unit, style, scale);
      this.#drawLegend(scale, style);
      if (scale) this.#layer.show({ raster, values, scale, style });
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
}
