import type { Area, AreaTable as AreaTableContract } from '../model/store.js';
import { inTransaction, withReadErrors, type Connection } from './connection.js';
import { Contents } from './contents.js';
import { decodePolygon, encodePolygon } from './geopackage-geometry.js';
import { RowReader, type Row } from './row-reader.js';
import type { Statement } from './sqlite.js';

/** Named areas; an area put again replaces the one of that name. */
export class AreaTable implements AreaTableContract {
  readonly #connection: Connection;
  readonly #contents: Contents;
  readonly #put: Statement;
  readonly #get: Statement;
  readonly #list: Statement;

  constructor(connection: Connection) {
    const { db } = connection;
    this.#connection = connection;
    this.#contents = new Contents(db, 'areas');
    this.#put = db.prepare(
      'INSERT INTO areas (geom, name, title) VALUES (@geom, @name, @title) ON CONFLICT ' +
        '(name) DO UPDATE SET geom = @geom, title = @title',
    );
    this.#get = db.prepare('SELECT * FROM areas WHERE name = ?');
    this.#list = db.prepare('SELECT * FROM areas ORDER BY name');
  }

  put(area: Area): void {
    inTransaction(this.#connection, () => {
      this.#put.run({ name: area.name, title: area.title, geom: encodePolygon(area.polygon) });
      this.#contents.measure();
      this.#contents.touch(this.#connection.clock.now().toISOString());
    });
  }

  get(name: string): Area | undefined {
    return withReadErrors(this.#connection, () => {
      const row = this.#get.get(name) as Row | undefined;
      return row === undefined ? undefined : readArea(row);
    });
  }

  list(): Area[] {
    return withReadErrors(this.#connection, () => (this.#list.all() as Row[]).map(readArea));
  }
}

function readArea(row: Row): Area {
  const shown = `area ${String(row['name'])}`;
  const read = new RowReader(row, shown);
  const geom = row['geom'];
  if (!(geom instanceof Uint8Array)) return read.fail('geom', 'a geometry');
  return {
    name: read.text('name'),
    title: read.text('title'),
    polygon: decodePolygon(geom, shown),
  };
}
