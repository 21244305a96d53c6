import type { Vec2 } from './vec3.js';
import type { AnalysisLayer } from './analysis-layer.js';
import { toMessage } from './http/api.js';
import { colourlessText, valueText, type BandStyle } from './band-styles.js';
import { chooseScale, toGradient, type ColourScale } from './colour-scale.js';
import { byId, download, element, setText } from './dom.js';
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
  readonly #band = byId('analysis-band', HTMLSelectElement);
  readonly #legend = byId('analysis-legend', HTMLElement);
  readonly #ends = byId('analysis-ends', HTMLElement);
  #hasHoles = false;
  #raster: Raster | undefined;
  #save = (): void => undefined;
  #toText = String as (value: number) => string;
  /** The place whose value is shown. */
  #pointed: Vec2 | undefined;
  #turn = 0;

  constructor(layer: AnalysisLayer) {
    this.#layer = layer;
    const opacity = byId('analysis-opacity', HTMLInputElement);
    opacity.addEventListener('input', () => (layer.opacity = opacity.valueAsNumber / 100));
    this.#band.addEventListener('change', () => void this.#showBand());
    byId('analysis-save', HTMLButtonElement).addEventListener('click', () => this.#save());
  }

  async show({ file, hasHoles, caption, fileName }: Finished): Promise<void> {
    this.#hasHoles = hasHoles;
    this.#save = () => download(file, fileName);
    this.#raster = await openRaster(file);
    this.#band.replaceChildren();
    this.#raster.bands.forEach(({ name, style }, i) => {
      if (style && (name !== 'hole' || hasHoles)) {
        this.#band.append(element('option', { value: String(i) }, style.title));
      }
    });
    setText(byId('analysis-caption', HTMLElement), caption);
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
    const text = value === undefined ? 'no value' : this.#toText(value);
    setText(byId('analysis-value', HTMLElement), `Here: ${text}`);
  }

  /** Says what has no colour, and before it what went wrong just now: neither hides the other. */
  #showNote(style: BandStyle, trouble = ''): void {
    const texts = [trouble, colourlessText(style, this.#hasHoles)];
    setText(byId('analysis-note', HTMLElement), texts.filter((text) => text !== '').join(' '));
  }

  async #showBand(): Promise<void> {
    this.#turn += 1;
    const [raster, turn] = [this.#raster, this.#turn];
    if (raster === undefined) return;
    const number = Number(this.#band.value);
    const { unit, style } = raster.bands[number] ?? {};
    if (unit === undefined || style === undefined) return;
    this.#showNote(style);
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
      this.#showNote(style, `The raster could not be shown. ${toMessage(error)}`);
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
    this.#legend.style.backgroundImage = toGradient(ramp, words !== undefined);
  }
}
