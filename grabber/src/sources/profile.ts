import type { Source } from './source.js';

/** What the store keeps about where a file came from. */
export type SourceProfile = {
  readonly id: string;
  /** False for --url-template and --from without --source: nothing is known then but what the user typed. */
  readonly configured: boolean;
  readonly crs: string | null;
  readonly class_table: string | null;
  readonly licence: string | null;
  readonly attribution: string | null;
  readonly square_m: number;
  readonly missing_status: readonly number[];
  readonly max_concurrent: number;
};

export function profileOf(source: Source): SourceProfile {
  const { id, crs, class_table, licence, attribution, square_m, missing_status, max_concurrent } = source;
  return { id, configured: true, crs, class_table, licence, attribution, square_m, missing_status, max_concurrent };
}
