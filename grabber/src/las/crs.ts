/** Ref: ASPRS, "LAS Specification 1.4 - R15", 2019, section 3.2: records of the CRS. */
const kUser = 'LASF_Projection';
const kWktRecord = 2112;
const kKeysRecord = 34735;
/** Ref: OGC 19-008r4, "OGC GeoTIFF Standard", 2019, section 7: ids of keys. */
const kGeographicKey = 2048;
const kProjectedKey = 3072;
/** Codes outside this range are private, or mean "user-defined". */
const kCodes = { first: 1024, last: 32766 };

/** A variable length record of a LAS file. */
export type Vlr = { readonly user: string; readonly record: number; readonly data: Buffer };

/**
 * The CRS of a LAS file, as voxelserver/data/lidar reads it: its WKT, else its GeoTIFF keys.
 * @return `EPSG:n` without its vertical part; undefined where the file has none, or one without a
 * code
 */
export function readCrs(vlrs: Iterable<Vlr>): string | undefined {
  let wkt = '';
  let keys: Buffer | undefined;
  for (const { user, record, data } of vlrs) {
    if (user !== kUser) continue;
    if (record === kWktRecord) wkt = data.toString('latin1').replace(/\0[^]*$/, '');
    if (record === kKeysRecord) keys = data;
  }
  const code = wkt === '' ? keys && readKeyCode(keys) : parseWktCode(wkt);
  return code === undefined ? undefined : `EPSG:${code}`;
}

function readKeyCode(keys: Buffer): number | undefined {
  const found = new Map<number, number>();
  // Four numbers a key, after four of the directory: id, where its value lies, count, value.
  for (let at = 8; at + 8 <= keys.length; at += 8) {
    const isHere = keys.readUInt16LE(at + 2) === 0;
    if (isHere) found.set(keys.readUInt16LE(at), keys.readUInt16LE(at + 6));
  }
  const code = found.get(kProjectedKey) ?? found.get(kGeographicKey);
  return code !== undefined && code >= kCodes.first && code <= kCodes.last ? code : undefined;
}

/**
 * The code of the horizontal system of WKT 1 or 2: that of the projected system, or of the
 * geographic one where there is no projected one.
 */
export function parseWktCode(wkt: string): number | undefined {
  const start =
    /\b(?:PROJCS|PROJCRS|PROJECTEDCRS)\s*[[(]/i.exec(wkt) ??
    /\b(?:GEOGCS|GEOGCRS|GEODCRS|GEOGRAPHICCRS|GEODETICCRS)\s*[[(]/i.exec(wkt);
  if (start === null) return undefined;
  // Text in quotes first, since it may hold brackets.
  const token = /"(?:[^"]|"")*"|(?:AUTHORITY|ID)\s*[[(]\s*"EPSG"\s*,\s*"?(\d{4,5})"?|[[(]|[\])]/gi;
  token.lastIndex = start.index + start[0].length;
  let depth = 1;
  for (let match = token.exec(wkt); match !== null && depth > 0; match = token.exec(wkt)) {
    const [text, code] = match;
    if (code !== undefined && depth === 1) return Number(code);
    if (code !== undefined || /^[[(]/.test(text)) ++depth;
    else if (/^[\])]/.test(text)) --depth;
  }
  return undefined;
}
