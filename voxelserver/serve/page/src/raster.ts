import { fromArrayBuffer } from 'geotiff';
import { readStyle, type BandStyle } from './band-styles.js';

/** A raster of an analysis, a Cloud Optimized GeoTIFF, at the resolution at which it is shown. */
export type Raster = {
  readonly width: number;
  readonly height: number;
  /** West, south, east, north, CRS units. */
  readonly extent: readonly [number, number, number, number];
  readonly bands: readonly {
    readonly name: string;
    readonly unit: string;
    /** Undefined: it is not drawn. */
    readonly style: BandStyle | undefined;
  }[];
  readonly noData: number;
  /** The values of a band, row by row from the north-west. */
  readonly readBand: (band: number) => Promise<Float32Array>;
};

/** Cells that a browser shows at once: a coarser level of larger rasters is shown. */
const kShownCells = 2_000_000;

/** @throws Error for what is no such raster */
export async function openRaster(file: Blob): Promise<Raster> {
  const tiff = await fromArrayBuffer(await file.arrayBuffer());
  const finest = await tiff.getImage();
  const levels = await tiff.getImageCount();
  let shown = finest;
  for (let level = 1; level < levels; ++level) {
    if (shown.getWidth() * shown.getHeight() <= kShownCells) break;
    shown = await tiff.getImage(level);
  }
  const [west, south, east, north] = finest.getBoundingBox();
  const bands: Raster['bands'][number][] = [];
  // One after the other: asked for at once, all but the first come without their names.
  for (let i = 0; i < finest.getSamplesPerPixel(); ++i) {
    const about = ((await finest.getGDALMetadata(i)) ?? {}) as Record<string, string>;
    bands.push({
      name: about['DESCRIPTION'] ?? `band ${i + 1}`,
      unit: about['UNITTYPE'] ?? '',
      style: readStyle(about),
    });
  }
  return {
    width: shown.getWidth(),
    height: shown.getHeight(),
    extent: [west!, south!, east!, north!],
    bands,
    noData: finest.getGDALNoData() ?? NaN,
    readBand: async (band) => (await shown.readRasters({ samples: [band] }))[0] as Float32Array,
  };
}
