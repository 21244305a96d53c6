import type { FetchJob } from '../fetch/fetch-job.js';
import type { Access, SourceClient } from '../fetch/http-client.js';
import { checkLidar, checkLidarStart, kLidarExtensions } from '../fetch/lidar-check.js';
import { readSecretHeaders } from '../fetch/secret-headers.js';
import type { StoreRecord } from '../model/square.js';
import type { Catalogue, Store } from '../model/store.js';
import type { AccessProfile } from '../sources/profile.js';
import type { FetchHooks } from './fill-store.js';
import type { RunOptions } from './run-options.js';

const kGib_bytes = 1024 ** 3;

/** @throws GrabberError SECRET when the environment lacks one */
export function toAccess(profile: AccessProfile): Access {
  return {
    hosts: profile.hosts,
    privateOrigins: profile.privateOrigins,
    secretHeaders: readSecretHeaders(profile.secretHeaders, process.env),
    secretOrigins: profile.secretOrigins,
  };
}

/** Squares of one source; `http` may contact its hosts. */
export function lidarJob(
  records: readonly StoreRecord[],
  profile: AccessProfile,
  catalogue: Catalogue,
  store: Store,
  http: SourceClient,
  allowFiles: boolean,
  options: RunOptions,
  hooks: FetchHooks,
): FetchJob {
  const convert = hooks.converter?.(store);
  return {
    kind: 'lidar',
    table: store.squares,
    records,
    http,
    limits: {
      max_concurrent: options.concurrency ?? profile.max_concurrent,
      max_per_s: profile.max_per_s,
    },
    missingStatus: profile.missing_status,
    max_bytes: options.maxFileGib * kGib_bytes,
    allowFiles,
    extensions: kLidarExtensions,
    checkStart: checkLidarStart,
    check: checkLidar,
    locate: catalogue.locate?.bind(catalogue),
    addressesExpire: catalogue.addressesExpire ?? false,
    ...(convert === undefined ? {} : { convert }),
  };
}
