import assert from 'node:assert/strict';
import { DataError, type DataErrorKind } from '../../../voxelserver/serve/page/src/http/errors.js';

/** The kind of the DataError that this throws. */
export function catchKind(work: () => unknown): DataErrorKind | 'none' {
  try {
    work();
    return 'none';
  } catch (error) {
    assert.ok(error instanceof DataError, String(error));
    return error.kind;
  }
}

export async function kindOfAsync(work: Promise<unknown>): Promise<DataErrorKind | 'none'> {
  const [result] = await Promise.allSettled([work]);
  return catchKind(() => {
    if (result.status === 'rejected') throw result.reason;
  });
}
