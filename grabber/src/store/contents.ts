import { envelopeOfBlob, type Envelope } from './geopackage-geometry.js';
import type { Database, Statement } from './sqlite.js';

/**
 * Keeps the row of a layer in gpkg_contents up to date: its extent, and when it last changed.
 * Called within the change's transaction.
 */
export class Contents {
  readonly #touch: Statement;
  readonly #grow: Statement;
  readonly #set: Statement;
  readonly #geometries: Statement;

  constructor(db: Database, table: string) {
    const where = `WHERE table_name = '${table}'`;
    this.#touch = db.prepare(`UPDATE gpkg_contents SET last_change = ? ${where}`);
    this.#grow = db.prepare(
      'UPDATE gpkg_contents SET min_x = min(coalesce(min_x, @a), @a), max_x = ' +
        'max(coalesce(max_x, @b), @b), ' +
        `min_y = min(coalesce(min_y, @c), @c), max_y = max(coalesce(max_y, @d), @d) ${where}`,
    );
    this.#set = db.prepare(
      `UPDATE gpkg_contents SET min_x = ?, max_x = ?, min_y = ?, max_y = ? ${where}`,
    );
    this.#geometries = db.prepare(
      `SELECT substr(geom, 1, 40) AS start FROM ${table} WHERE geom IS NOT NULL`,
    );
  }

  touch(now: string): void {
    this.#touch.run(now);
  }

  grow([a, b, c, d]: Envelope): void {
    this.#grow.run({ a, b, c, d });
  }

  /** After a geometry has moved: the extent may have shrunk. */
  measure(): void {
    const extent = new Extent();
    for (const { start } of this.#geometries.iterate() as Iterable<{ start: Uint8Array }>) {
      extent.add(start);
    }
    this.#set.run(...(extent.envelope ?? [null, null, null, null]));
  }
}

/** Collects the extent of geometries. */
export class Extent {
  envelope: Envelope | undefined;

  add(blob: Uint8Array | null): void {
    const one = blob === null ? undefined : envelopeOfBlob(blob);
    if (one === undefined) return;
    const [a, b, c, d] = this.envelope ?? one;
    this.envelope = [
      Math.min(a, one[0]),
      Math.max(b, one[1]),
      Math.min(c, one[2]),
      Math.max(d, one[3]),
    ];
  }
}
