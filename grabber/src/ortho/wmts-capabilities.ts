import { XMLParser } from 'fast-xml-parser';
import { z } from 'zod';
import { GrabberError } from '../util/errors.js';
import type { TileMatrix } from './wmts-matrix.js';

/** What is needed of a tile service to request tiles of one layer. */
export type TileService = {
  readonly crs: string;
  readonly matrices: readonly TileMatrix[];
  /** Address with {TileMatrix} {TileRow} {TileCol} and more; undefined = by parameters at `kvp`. */
  readonly template: string | undefined;
  readonly kvp: string;
};

export type Wanted = {
  readonly layer: string;
  readonly matrixSet: string;
  readonly format: string;
  readonly axis: 'en' | 'ne';
};

/**
 * Side of a pixel on the screen that scale denominators are meant for. Ref: OGC 07-057r7 (WMTS
 * 1.0), 6.1.
 */
const kScreenPixel_m = 0.00028;

const one = z.union([z.string(), z.number()]).transform(String);
/** An element that may stand once, often or not at all. */
const list = <T extends z.ZodType>(item: T) => z.preprocess(asList, z.array(item));
const count = z.coerce.number().int().min(1);
const matrixSchema = z.object({
  Identifier: one,
  ScaleDenominator: z.coerce.number().positive(),
  TopLeftCorner: one,
  TileWidth: count,
  TileHeight: count,
  MatrixWidth: count,
  MatrixHeight: count,
});
const capabilitiesSchema = z.object({
  Capabilities: z.object({
    Contents: z.object({
      Layer: list(
        z.object({
          Identifier: one,
          ResourceURL: list(z.object({ '@format': one, '@resourceType': one, '@template': one })),
        }),
      ),
      TileMatrixSet: list(
        z.object({ Identifier: one, SupportedCRS: one, TileMatrix: list(matrixSchema) }),
      ),
    }),
  }),
});

function asList(value: unknown): unknown[] {
  if (value === undefined) return [];
  return Array.isArray(value) ? value : [value];
}

/** @throws GrabberError MAP_SERVICE naming what is not there */
export function parseCapabilities(xml: string, url: string, wanted: Wanted): TileService {
  const contents = readXml(xml, url).Capabilities.Contents;
  const fail = (what: string, allowed: string): never => {
    throw new GrabberError(
      'MAP_SERVICE',
      `read the tile service ${url}: ${what}; allowed: ${allowed}`,
    );
  };
  const layer = contents.Layer.find((found) => found.Identifier === wanted.layer);
  if (layer === undefined) {
    return fail(
      `no layer "${wanted.layer}"`,
      contents.Layer.slice(0, 20)
        .map((found) => found.Identifier)
        .join(', ') || 'one with layers',
    );
  }
  const set = contents.TileMatrixSet.find((found) => found.Identifier === wanted.matrixSet);
  if (set === undefined) {
    return fail(
      `no matrix set "${wanted.matrixSet}"`,
      contents.TileMatrixSet.map((found) => found.Identifier).join(', ') || 'one with matrix sets',
    );
  }
  const crs = parseCrsName(set.SupportedCRS);
  if (crs === undefined) {
    return fail(
      `matrix set ${wanted.matrixSet} in ${set.SupportedCRS}`,
      'an EPSG system in metres',
    );
  }
  const matrices = set.TileMatrix.map((matrix): TileMatrix => {
    const corner = matrix.TopLeftCorner.trim().split(/\s+/).map(Number);
    const [left_m, top_m] = wanted.axis === 'ne' ? [corner[1], corner[0]] : corner;
    if (left_m === undefined || top_m === undefined || !Number.isFinite(left_m + top_m)) {
      return fail(`corner "${matrix.TopLeftCorner}" of matrix ${matrix.Identifier}`, 'two numbers');
    }
    return {
      id: matrix.Identifier,
      resolution_m: matrix.ScaleDenominator * kScreenPixel_m,
      left_m,
      top_m,
      tile_px: matrix.TileWidth,
      tile_height_px: matrix.TileHeight,
      columns: matrix.MatrixWidth,
      rows: matrix.MatrixHeight,
    };
  });
  const template = layer.ResourceURL.find(
    (found) => found['@resourceType'] === 'tile' && found['@format'] === wanted.format,
  )?.['@template'];
  const query = new URL(url);
  query.search = '';
  return { crs, matrices, template, kvp: query.href };
}

function readXml(xml: string, url: string): z.infer<typeof capabilitiesSchema> {
  // Definitions of entities are how XML is made to grow without end.
  if (/<!(DOCTYPE|ENTITY)/i.test(xml)) {
    throw new GrabberError(
      'MAP_SERVICE',
      `read the tile service ${url}: its XML defines a document type; allowed: plain capabilities`,
    );
  }
  try {
    const parser = new XMLParser({
      ignoreAttributes: false,
      attributeNamePrefix: '@',
      removeNSPrefix: true,
      parseTagValue: false,
      parseAttributeValue: false,
    });
    return capabilitiesSchema.parse(parser.parse(xml));
  } catch (error) {
    throw new GrabberError(
      'MAP_SERVICE',
      `read the tile service ${url}: no capabilities of WMTS 1.0; allowed: those`,
      { cause: error },
    );
  }
}

/** urn:ogc:def:crs:EPSG::3857 or EPSG:3857; degrees have no pixel size in metres. */
function parseCrsName(text: string): string | undefined {
  const number = /EPSG:(?:[0-9.]*:)?(\d{4,6})$/.exec(text.trim())?.[1];
  return number === undefined || number === '4326' || number === '4258'
    ? undefined
    : `EPSG:${number}`;
}
