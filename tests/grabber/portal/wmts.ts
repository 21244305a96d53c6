import type { IncomingMessage, ServerResponse } from 'node:http';
import { drawPattern, encodePng } from './pattern.js';

export type WmtsOptions = {
  readonly layer: string;
  readonly crs: string;
  /** Of the north-western corner of all matrices. */
  readonly left_m: number;
  readonly top_m: number;
  readonly tile_px: number;
  /** The width when left out. */
  readonly tile_height_px?: number;
  readonly resolutions_m: readonly number[];
  /** Tiles to each side. */
  readonly tiles: number;
  /**
   * Write an address template into the capabilities; without it tiles are requested by parameters.
   */
  readonly rest: boolean;
  /** Corners with the northing first. */
  readonly northingFirst?: boolean;
  /** "matrix/row/column" of tiles that are not there, and of those that are one grey. */
  readonly missing?: ReadonlySet<string>;
  readonly grey?: ReadonlySet<string>;
};

/**
 * A tile server that cuts the synthetic picture.
 * @return whether the request was for it (path /wmts...)
 */
export function wmtsHandler(
  options: WmtsOptions,
): (request: IncomingMessage, response: ServerResponse) => boolean {
  return (request, response) => {
    const url = new URL(request.url ?? '/', `http://${request.headers.host ?? 'portal'}`);
    if (!url.pathname.startsWith('/wmts')) return false;
    if (url.searchParams.get('REQUEST') === 'GetCapabilities') {
      response
        .writeHead(200, { 'content-type': 'text/xml' })
        .end(capabilities(options, url.origin));
      return true;
    }
    const rest = /^\/wmts\/[^/]+\/[^/]+\/(\w+)\/(\d+)\/(\d+)\.png$/.exec(url.pathname);
    const words =
      rest?.slice(1, 4) ??
      ['TILEMATRIX', 'TILEROW', 'TILECOL'].map((name) => url.searchParams.get(name) ?? '');
    sendTile(options, words, response);
    return true;
  };
}

function sendTile(
  options: WmtsOptions,
  [matrix = '', row = '', column = '']: readonly string[],
  response: ServerResponse,
): void {
  const name = `${matrix}/${row}/${column}`;
  const step = options.resolutions_m[Number(matrix.slice(1))];
  const there = step !== undefined && Number(row) < options.tiles && Number(column) < options.tiles;
  if (!there || options.missing?.has(name) === true) {
    response.writeHead(404).end();
    return;
  }
  const [px, height_px] = [options.tile_px, options.tile_height_px ?? options.tile_px];
  const [width, height] = [px * step, height_px * step];
  const [west, north] = [
    options.left_m + Number(column) * width,
    options.top_m - Number(row) * height,
  ];
  const png =
    options.grey?.has(name) === true
      ? encodePng(Buffer.alloc(px * height_px, 128), px, height_px, 1)
      : encodePng(
          drawPattern([west, north - height, west + width, north], px, height_px),
          px,
          height_px,
        );
  response
    .writeHead(200, { 'content-type': 'image/png', 'content-length': String(png.length) })
    .end(png);
}

function capabilities(options: WmtsOptions, origin: string): string {
  const corner =
    options.northingFirst === true
      ? `${options.top_m} ${options.left_m}`
      : `${options.left_m} ${options.top_m}`;
  const size = `<TileWidth>${options.tile_px}</TileWidth>
      <TileHeight>${options.tile_height_px ?? options.tile_px}</TileHeight>
      <MatrixWidth>${options.tiles}</MatrixWidth><MatrixHeight>${options.tiles}</MatrixHeight>`;
  const matrices = options.resolutions_m.map(
    (step, index) => `<TileMatrix><ows:Identifier>m${index}</ows:Identifier>
      <ScaleDenominator>${step / 0.00028}</ScaleDenominator>
      <TopLeftCorner>${corner}</TopLeftCorner>${size}</TileMatrix>`,
  );
  const resource =
    '<ResourceURL format="image/png" resourceType="tile" ' +
    `template="${origin}/wmts/{TileMatrixSet}/{Style}/{TileMatrix}/{TileRow}/{TileCol}.png"/>`;
  return `<?xml version="1.0"?>
    <Capabilities xmlns="http://www.opengis.net/wmts/1.0"
      xmlns:ows="http://www.opengis.net/ows/1.1" version="1.0.0"><Contents>
    <Layer><ows:Identifier>${options.layer}</ows:Identifier>${options.rest ? resource : ''}</Layer>
    <TileMatrixSet><ows:Identifier>set</ows:Identifier>
    <ows:SupportedCRS>urn:ogc:def:crs:EPSG::${options.crs.slice(5)}</ows:SupportedCRS>
    ${matrices.join('')}</TileMatrixSet></Contents></Capabilities>`;
}
