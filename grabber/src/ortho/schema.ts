import { z } from 'zod';
import type { ConfigKind } from '../config/toml-file.js';
import {
  originOfTemplate,
  originsOfHost,
  hostName,
  kSourceId,
  kSourceIdAllowed,
} from '../sources/source.js';
import { isRegExp } from '../sources/access-schema.js';

export const kAllowed = {
  id: `${kSourceIdAllowed}, the same as the file name`,
  title: 'text of 1 to 200 characters',
  licence: 'text of 1 to 200 characters',
  attribution: 'text of 1 to 200 characters',
  crs: 'EPSG:<number>, such as EPSG:3794: the CRS of requests and pictures',
  resolution_m: 'a number from 0.01 to 100, metres a pixel',
  bands: '"rgb" or "rgbi" (the fourth is near infrared)',
  max_concurrent: 'an integer from 1 to 32, requests at a time',
  missing_status: 'a list of HTTP statuses from 400 to 499',
  hosts: 'a list of further host names that may be contacted, host or host:port',
  allow_private_addresses: 'true or false',
  secret_headers: 'a table of header = name of an environment variable',
  access: 'a table with kind = "wms", "wmts", "stac" or "template" and the fields of that kind',
  'access.url': 'an http(s) address',
  'access.version': '"1.1.1" or "1.3.0"',
  'access.axis':
    '"en" (easting first, the default) or "ne", the order that the CRS has in its registry',
  'access.northing_first': 'a list of EPSG:<number> whose registry entry has the northing first',
  more_crs: 'a list of EPSG:<number>: others in which the server draws',
  'access.max_pixels': 'an integer from 64 to 10000, the longest side of a picture',
  'access.format': '"image/jpeg", "image/png" or "image/tiff"',
  'access.asset': 'a regular expression that the address of an asset matches',
  'access.matrices':
    'a list of tables with id, resolution_m, left_m, top_m, tile_px, columns, rows, and ' +
    'tile_height_px where tiles are not square',
  'access.place':
    '"square" (the picture covers its square) or "file" (a GeoTIFF says where it lies)',
} as const;

const text = z.string().min(1).max(200);
const crs = z.string().regex(/^EPSG:\d{4,6}$/);
const address = z
  .string()
  .refine((url) => URL.canParse(url) && ['http:', 'https:'].includes(new URL(url).protocol));
const format = z.enum(['image/jpeg', 'image/png', 'image/tiff']);

/** Web Map Service: a picture of any rectangle. */
const wms = z.strictObject({
  kind: z.literal('wms'),
  url: address,
  version: z.enum(['1.1.1', '1.3.0']).default('1.3.0'),
  /**
   * Systems whose registry entry has the northing first, which 1.3.0 obeys; 1.1.1 always has
   * easting first.
   */
  northing_first: z.array(crs).default([]),
  layer: text,
  style: z.string().max(200).default(''),
  format: format.default('image/png'),
  transparent: z.boolean().default(false),
  max_pixels: z.int().min(64).max(10_000).default(2048),
});

const matrix = z.strictObject({
  id: text,
  resolution_m: z.number().positive(),
  left_m: z.number(),
  top_m: z.number(),
  tile_px: z.int().min(16).max(4096),
  tile_height_px: z.int().min(16).max(4096).optional(),
  columns: z.int().min(1),
  rows: z.int().min(1),
});

/** Web Map Tile Service: the matrices are read from its capabilities unless they stand here. */
const wmts = z.strictObject({
  kind: z.literal('wmts'),
  /**
   * Of its capabilities; with `matrices`, of a tile: {matrix_set} {matrix} {row} {column} {style}
   * {time}.
   */
  url: z.string().refine((url) => URL.canParse(url.replace(/\{[a-z_]+\}/g, '0'))),
  layer: text.optional(),
  style: z.string().max(200).default('default'),
  format: format.default('image/jpeg'),
  matrix_set: text,
  axis: z.enum(['en', 'ne']).default('en'),
  matrices: z.array(matrix).min(1).optional(),
});

/** SpatioTemporal Asset Catalog: files with the places they cover. */
const stac = z.strictObject({
  kind: z.literal('stac'),
  url: address,
  asset: z.string().refine(isRegExp),
});

/** A picture a square, at an address of its own. */
const template = z.strictObject({
  kind: z.literal('template'),
  url: z.string().refine((url) => /^https?:\/\//.test(url)),
  square_m: z.int().min(1).max(100_000).default(1000),
  place: z.enum(['square', 'file']).default('square'),
});

export const orthoSchema = z.strictObject({
  id: z.string().regex(kSourceId),
  title: text,
  licence: text,
  attribution: text,
  crs,
  more_crs: z.array(crs).default([]),
  resolution_m: z.number().min(0.01).max(100),
  bands: z.enum(['rgb', 'rgbi']).default('rgb'),
  max_concurrent: z.int().min(1).max(32).default(4),
  missing_status: z.array(z.int().min(400).max(499)).default([404]),
  hosts: z.array(hostName).default([]),
  allow_private_addresses: z.boolean().default(false),
  secret_headers: z.record(z.string(), z.string().regex(/^[A-Z][A-Z0-9_]*$/)).default({}),
  access: z.discriminatedUnion('kind', [wms, wmts, stac, template]),
});

/** One provider of orthophotos. */
export type OrthoSource = z.infer<typeof orthoSchema>;
export type WmsAccess = z.infer<typeof wms>;
export type WmtsAccess = z.infer<typeof wmts>;
export type StacAccess = z.infer<typeof stac>;
export type TemplateAccess = z.infer<typeof template>;

export const kOrthoKind: ConfigKind<OrthoSource> = {
  what: 'orthophoto source',
  schema: orthoSchema,
  allowed: kAllowed,
};

/** Hosts that a source permits: those of its addresses and those that it names. */
export function orthoHosts(source: OrthoSource): string[] {
  return [
    ...new Set([new URL(source.access.url.replace(/\{[^}]*\}/g, '0')).host, ...source.hosts]),
  ];
}

/**
 * Those that may lead to private addresses: all that the source names when it allows that, else
 * none.
 */
export function orthoPrivateOrigins(source: OrthoSource): string[] {
  if (!source.allow_private_addresses) return [];
  return [
    ...new Set([originOfTemplate(source.access.url), ...source.hosts.flatMap(originsOfHost)]),
  ];
}
