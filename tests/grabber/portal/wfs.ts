import type { ServerResponse } from 'node:http';
import { overlap, parseBox, type Box } from './ground.js';
import { toUrl, sendJson, type PortalHandler } from './portal.js';

const kPage = 1000;

/**
 * A WFS 2.0.0 like that of IGN: GetFeature as GeoJSON in the squares' CRS, with count and
 * startIndex.
 */
export const wfsHandler: PortalHandler = (request, response, context) => {
  const { pathname, searchParams } = toUrl(request);
  if (pathname !== '/wfs') return false;
  const query = new Map([...searchParams].map(([name, value]) => [name.toLowerCase(), value]));
  if (query.get('request')?.toLowerCase() !== 'getfeature') {
    return sendException(response, `request ${query.get('request') ?? 'none'} is not supported`);
  }
  const bbox = parseBox(query.get('bbox') ?? null);
  const [count, from] = [Number(query.get('count') ?? kPage), Number(query.get('startindex') ?? 0)];
  const fitting = context.squares.filter(({ east_km, north_km }) => {
    const box: Box = [
      east_km * 1000,
      north_km * 1000,
      east_km * 1000 + 1000,
      north_km * 1000 + 1000,
    ];
    return bbox === undefined || overlap(box, bbox);
  });
  const features = fitting
    .slice(from, from + Math.min(count, kPage))
    .map(({ name, east_km, north_km, path }, index) => {
      const [west, south] = [east_km * 1000, north_km * 1000];
      const ring = [
        [west, south],
        [west + 1000, south],
        [west + 1000, south + 1000],
        [west, south + 1000],
        [west, south],
      ];
      return {
        type: 'Feature',
        id: `metadata.${from + index}`,
        geometry: { type: 'Polygon', coordinates: [ring] },
        geometry_name: 'geom',
        properties: { name: `TM_${name}`, ti_name: name, url_npl: `${context.base}/${path}` },
      };
    });
  const crs = {
    type: 'name',
    properties: { name: `urn:ogc:def:crs:${context.crs.replace(':', '::')}` },
  };
  sendJson(response, {
    type: 'FeatureCollection',
    features,
    totalFeatures: fitting.length,
    numberMatched: fitting.length,
    numberReturned: features.length,
    crs,
  });
  return true;
};

/** Such servers report errors with status 200. */
function sendException(response: ServerResponse, text: string): true {
  const body =
    '<?xml version="1.0"?><ows:ExceptionReport xmlns:ows="http://www.opengis.net/ows/1.1" ' +
    'version="2.0.0"><ows:Exception exceptionCode="OperationNotSupported">' +
    `<ows:ExceptionText>${text.replace(/[<&]/g, ' ')}</ows:ExceptionText>` +
    '</ows:Exception></ows:ExceptionReport>';
  response.writeHead(200, { 'content-type': 'application/xml' }).end(body);
  return true;
}
