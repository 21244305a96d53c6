import ImageLayer from 'ol/layer/Image.js';
import type Projection from 'ol/proj/Projection.js';
import ImageStatic from 'ol/source/ImageStatic.js';
import type { BandStyle } from './band-styles.js';
import { element, getContext2d } from './dom.js';
import { paint, type ColourScale } from './colour-scale.js';
import type { Raster } from './raster.js';
import type { WorldProjection } from './world-projection.js';

/** One band of a raster, with its values for the place under the pointer. */
export type ShownBand = {
  readonly raster: Raster;
  readonly values: Float32Array;
  readonly scale: ColourScale;
  readonly style: BandStyle;
};

/**
 * The result of an analysis as colours over the top view, and below the frames and names of squares
 * and boxes. It is opaque at first: mixed with what is below, colours are no longer those of the
 * legend.
 */
export class AnalysisLayer {
  readonly layer = new ImageLayer<ImageStatic>({ zIndex: 2, visible: false });
  readonly #projection: Projection;
  readonly #unitsPerRasterUnit: number;
  #shown: ShownBand | undefined;
  /** West, south, east, north, units of the map. */
  #extent: readonly [number, number, number, number] = [0, 0, 0, 0];

  constructor(projection: Projection, world: WorldProjection) {
    this.#projection = projection;
    // Rasters of a world without a CRS are in metres.
    this.#unitsPerRasterUnit = world.world.crs === '' ? 1 / world.metresPerUnit : 1;
  }

  show(shown: ShownBand): void {
    this.#shown = shown;
    const { raster, values, scale, style } = shown;
    const { width, height, noData } = raster;
    const [west, south, east, north] = raster.extent;
    const u = this.#unitsPerRasterUnit;
    this.#extent = [west * u, south * u, east * u, north * u];
    const canvas = element('canvas', { width, height });
    const context = getContext2d(canvas);
    const image = context.createImageData(width, height);
    const coloured = style.words ? values.map((value) => (value === 0 ? noData : value)) : values;
    paint(coloured, noData, scale, style.ramp, image.data);
    context.putImageData(image, 0, 0);
    const url = canvas.toDataURL('image/png');
    const imageExtent = [...this.#extent];
    this.layer.setSource(
      new ImageStatic({ url, imageExtent, projection: this.#projection, interpolate: false }),
    );
    this.layer.setVisible(true);
  }

  clear(): void {
    this.#shown = undefined;
    this.layer.setVisible(false);
    this.layer.setSource(null);
  }

  set opacity(share: number) {
    this.layer.setOpacity(share);
  }

  /** @return undefined where the raster has no value, or ends */
  valueAt(easting: number, northing: number): number | undefined {
    if (this.#shown === undefined) return undefined;
    const { raster, values } = this.#shown;
    const { width, height, noData } = raster;
    const [west, south, east, north] = this.#extent;
    const column = Math.floor(((easting - west) / (east - west)) * width);
    const row = Math.floor(((north - northing) / (north - south)) * height);
    if (column < 0 || row < 0 || column >= width || row >= height) return undefined;
    const value = values[row * width + column];
    return value === undefined || value === noData || Number.isNaN(value) ? undefined : value;
  }
}
