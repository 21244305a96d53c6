/**
 * Identifies a version of a file on a web server: the validators of its replies, and the size of
 * the file. The rules are those of voxelserver/make/worlds/archive/archive_kind.cpp.
 * Ref: RFC 9110, 8.8, 13.1 and 14.4.
 */
export type FileState = {
  /** With its quotes, `W/` before a weak one. */
  readonly etag: string | undefined;
  /** As the server wrote it. */
  readonly lastModified: string | undefined;
  /** Of the whole file. */
  readonly bytes: number | undefined;
};

/** `bytes FIRST-LAST/SIZE`; parts that the server left out are undefined. */
export type ContentRange = {
  readonly first: number | undefined;
  readonly last: number | undefined;
  readonly size: number | undefined;
};

const kMaxEtag = 512;
const kEtag = /^(?:W\/)?"[\x21\x23-\x7e]*"$/;
const kDate = /^[A-Z][a-z]{2}, \d{2} [A-Z][a-z]{2} \d{4} \d{2}:\d{2}:\d{2} GMT$/;
const kContentRange = /^bytes (?:(\d{1,15})-(\d{1,15})|\*)\/(?:(\d{1,15})|\*)$/;

/** A header that is not of the form that RFC 9110 prescribes counts as absent. */
export function parseContentRange(headers: Headers): ContentRange | undefined {
  const found = kContentRange.exec(headers.get('Content-Range') ?? '');
  if (found === null) return undefined;
  const number = (text: string | undefined): number | undefined =>
    text === undefined ? undefined : Number(text);
  return { first: number(found[1]), last: number(found[2]), size: number(found[3]) };
}

/** @param bytes of the whole file, where the reply states them */
export function readFileState(headers: Headers, bytes: number | undefined): FileState {
  const etag = headers.get('ETag') ?? '';
  const lastModified = headers.get('Last-Modified') ?? '';
  return {
    etag: etag.length <= kMaxEtag && kEtag.test(etag) ? etag : undefined,
    lastModified: kDate.test(lastModified) ? lastModified : undefined,
    bytes,
  };
}

/**
 * The header that makes a server answer 412 instead of sending bytes of another version: If-Match
 * with a strong entity tag, else If-Unmodified-Since; none where there is neither.
 */
export function toCondition(state: FileState): Record<string, string> {
  if (state.etag !== undefined && !isWeak(state.etag)) return { 'If-Match': state.etag };
  if (state.lastModified !== undefined) return { 'If-Unmodified-Since': state.lastModified };
  return {};
}

/**
 * Whether a later reply is of another version: by size, and by the best validator that both have.
 * With validators in the first reply alone, the versions cannot be compared and count as different;
 * without any there, only the size counts.
 */
export function isOtherVersion(first: FileState, later: FileState): boolean {
  if (first.bytes !== undefined && later.bytes !== undefined && first.bytes !== later.bytes) {
    return true;
  }
  if (first.etag !== undefined && later.etag !== undefined) {
    return opaque(first.etag) !== opaque(later.etag);
  }
  if (first.lastModified !== undefined && later.lastModified !== undefined) {
    return first.lastModified !== later.lastModified;
  }
  return first.etag !== undefined || first.lastModified !== undefined;
}

const isWeak = (etag: string): boolean => etag.startsWith('W/');

// Weak and strong tags of the same text are the same.
const opaque = (etag: string): string => (isWeak(etag) ? etag.slice(2) : etag);
