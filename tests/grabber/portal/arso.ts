import type { ServerResponse } from 'node:http';
import { sendPortalFile } from './files.js';
import { toUrl, type PortalHandler } from './portal.js';

/**
 * Files in folders of survey blocks with listings, as ARSO has them:
 * /lidar/gkot/laz/{block}/D96TM/TM_{E}_{N}.laz
 */
export const arsoHandler: PortalHandler = async (request, response, context) => {
  const { pathname, searchParams } = toUrl(request);
  const match = /^\/lidar\/gkot\/laz\/(?:(b_\d\d)\/(?:D96TM\/(?:TM_(\d+)_(\d+)\.laz)?)?)?$/.exec(
    pathname,
  );
  if (match === null) return false;
  const [, block, east, north] = match;
  if (block === undefined) {
    return sendListing(response, pathname, [
      ...new Set(context.squares.map((square) => `${square.block}/`)),
    ]);
  }
  const squares = context.squares.filter((square) => square.block === block);
  if (squares.length === 0) return false;
  if (east === undefined) {
    if (!pathname.endsWith('D96TM/')) return sendListing(response, pathname, ['D96TM/']);
    return sendListing(
      response,
      pathname,
      squares.map((square) => `TM_${square.name}.laz`),
    );
  }
  const square = squares.find((one) => one.name === `${east}_${north ?? ''}`);
  if (square === undefined) return false;
  return sendPortalFile(
    square.path,
    pathname,
    searchParams.has('direct'),
    request,
    response,
    context,
  );
};

function sendListing(response: ServerResponse, path: string, names: readonly string[]): true {
  const rows = names.map((name) => `<A HREF="${path}${name}">${name}</A><br>`).join('\n');
  response
    .writeHead(200, { 'content-type': 'text/html' })
    .end(`<html><head><title>${path}</title></head><body><pre>${rows}</pre></body></html>`);
  return true;
}
