import type { Terms } from '../model/square.js';
import { listHosts, listPrivateOrigins, listSecretOrigins } from './hosts.js';
import type { Source } from './source.js';

/** Limits and permissions for requests to the hosts of a source. */
export type AccessProfile = {
  /** Requests at a time, 1 to 32. */
  readonly max_concurrent: number;
  /** Requests a second, null = as fast as `max_concurrent` allows. */
  readonly max_per_s: number | null;
  /** HTTP statuses that mean "no such square". */
  readonly missing_status: readonly number[];
  /** Host names in lower case that may be contacted (sources/hosts.ts). */
  readonly hosts: readonly string[];
  /** Origins that may lead to loopback, link-local and private addresses (sources/hosts.ts). */
  readonly privateOrigins: readonly string[];
  /**
   * Header name -> NAME of the environment variable that holds its value; neither value nor header
   * is ever logged.
   */
  readonly secretHeaders: Readonly<Record<string, string>>;
  /** Origins that may receive the secret headers, as URL.origin writes them (sources/hosts.ts). */
  readonly secretOrigins: readonly string[];
  /** Edge of a square; null where files have no grid. */
  readonly square_m: number | null;
};

export function toProfile(source: Source): AccessProfile {
  return {
    max_concurrent: source.max_concurrent,
    max_per_s: source.max_per_s ?? null,
    missing_status: source.missing_status,
    hosts: listHosts(source),
    privateOrigins: listPrivateOrigins(source),
    secretHeaders: source.secret_headers,
    secretOrigins: listSecretOrigins(source),
    square_m: source.square_m ?? null,
  };
}

/** What is recorded with the files of a source. */
export function toTerms(source: Source): Terms {
  return {
    crs: source.crs_in_files ? null : source.crs,
    classTable: source.class_table,
    licence: source.licence,
    attribution: source.attribution,
  };
}
