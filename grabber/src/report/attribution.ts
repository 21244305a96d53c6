import type { StoreRecord } from '../model/square.js';
import { printableLine } from '../util/printable.js';

export type AttributionNames = {
  /** By source id; sources of the user's own have none. */
  readonly titles: ReadonlyMap<string, string>;
  /** By licence. */
  readonly addresses: ReadonlyMap<string, string>;
};

type Group = {
  readonly first: StoreRecord;
  readonly what: string;
  count: number;
  years: Set<number>;
};

/**
 * What must be said of the data when pictures of it are shown.
 * @param squares, orthophotos the usable ones
 */
export function attributionText(
  squares: readonly StoreRecord[],
  orthophotos: readonly StoreRecord[],
  names: AttributionNames,
): string {
  const groups = [...grouped(squares, 'LiDAR squares'), ...grouped(orthophotos, 'orthophotos')];
  if (groups.length === 0) return 'The store holds no data yet.\n';
  return groups.map((group) => groupText(group, names)).join('\n');
}

/** One text per source; several where its terms have changed over time. */
function grouped(records: readonly StoreRecord[], what: string): Group[] {
  const groups = new Map<string, Group>();
  for (const record of records) {
    const id = JSON.stringify([record.key.source, record.licence, record.attribution]);
    const group = groups.get(id) ?? { first: record, what, count: 0, years: new Set() };
    groups.set(id, group);
    ++group.count;
    const year = /^\d{4}/.exec(record.published ?? '')?.[0];
    if (year !== undefined) group.years.add(Number(year));
  }
  return [...groups.values()];
}

function groupText(
  { first, what, count, years }: Group,
  { titles, addresses }: AttributionNames,
): string {
  const { key, licence, attribution } = first;
  const title = titles.get(key.source);
  const address = licence === null ? undefined : addresses.get(licence);
  const lines = [
    title === undefined ? key.source : `${title} (${key.source})`,
    `  data:        ${count} ${what}`,
    `  years:       ${yearsText(years)}`,
    `  licence:     ${licence ?? 'not recorded'}`,
    ...(address === undefined ? [] : [`               ${address}`]),
    `  attribution: ${attribution ?? 'not recorded'}`,
  ];
  // Each of them is the text of a source or of a store, which must not look like further ones.
  return `${lines.map(printableLine).join('\n')}\n`;
}

function yearsText(years: ReadonlySet<number>): string {
  if (years.size === 0) return 'not recorded';
  const low = Math.min(...years);
  const high = Math.max(...years);
  return low === high ? String(low) : `${low} to ${high}`;
}
