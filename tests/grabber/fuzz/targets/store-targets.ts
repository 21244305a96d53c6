import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { readFishnet } from '../../../../grabber/src/select/fishnet-file.js';
import { readPolygonFile } from '../../../../grabber/src/select/region.js';
import { encodeFootprint, envelopeOfBlob } from '../../../../grabber/src/store/geometry.js';
import { storeLayout } from '../../../../grabber/src/store/layout.js';
import { openStore } from '../../../../grabber/src/store/open-store.js';
import { sourceWith } from '../../support/catalogue-fixture.js';
import { kNever, makeSquare } from '../../support/store-fixture.js';
import { arrived, arbitraryDamage } from '../damage.js';
import { acceptedOrRefused, type Target, kFolder, target } from './target.js';

export function geometryTargets(): Target[] {
  const good = encodeFootprint([462_000, 101_000, 463_000, 102_000], 'EPSG:3794');
  if (good === null) throw new Error('no polygon');
  const damaged = target('gpkg-geometry', 2000, arbitraryDamage(1), (input) => {
    const envelope = envelopeOfBlob(arrived([good], input));
    assert.ok(envelope === undefined || envelope.length === 4);
  });
  return [damaged];
}

export function storeTarget(): Target {
  const root = join(kFolder, 'store');
  const path = storeLayout(root).database;
  const store = openStore(root, {}, kNever);
  const terms = { crs: 'EPSG:3794', classTable: 'asprs', licence: 'CC0', attribution: 'Us' };
  const names = Array.from({ length: 40 }, (_unused, index) => `${462 + index}_101`);
  store.squares.learn(
    'here',
    'here',
    'EPSG:3794',
    terms,
    names.map((name) => makeSquare(name, [`https://h.example/${name}`])),
  );
  store.close();
  const good = readFileSync(path);
  return target('gpkg-store', 60, arbitraryDamage(1), (input) => {
    writeFileSync(path, arrived([good], input));
    return acceptedOrRefused(['STORE_FORMAT', 'STORE_DAMAGED', 'STORE_IO'], () => {
      const opened = openStore(root, { readOnly: true }, kNever);
      try {
        opened.squares.tally();
        return opened.squares.list({}).length + opened.orthophotos.list({}).length;
      } finally {
        opened.close();
      }
    });
  });
}

/**
 * Squares of the fishnet of a survey, as GDAL writes them in each format. Each run starts programs,
 * hence few runs.
 */
export function vectorTargets(): Target[] {
  const kinds = [
    { driver: 'GeoJSON', name: 'net.geojson' },
    { driver: 'ESRI Shapefile', name: 'net.shp' },
    { driver: 'ESRI Shapefile', name: 'net.dbf' },
    { driver: 'GPKG', name: 'net.gpkg' },
    { driver: 'KML', name: 'net.kml' },
    { driver: 'FlatGeobuf', name: 'net.fgb' },
  ];
  const source = sourceWith(
    '[access]\nkind = "template"\nurls = ["https://h.example/{E}_{N}.laz"]',
  );
  const square = [
    [14.4, 46],
    [14.5, 46],
    [14.5, 46.1],
    [14.4, 46],
  ];
  const features = ['462_101', '463_101'].map((NAME) => ({
    type: 'Feature',
    properties: { NAME, BLOK: 'b_35' },
    geometry: { type: 'Polygon', coordinates: [square] },
  }));
  const plain = join(kFolder, 'in.geojson');
  return kinds.map(({ driver, name }) => {
    // Made on first use: a run of another target needs no GDAL.
    let good: Buffer | undefined;
    const folder = join(kFolder, `vector-${driver.replaceAll(' ', '-')}-${name}`);
    const path = join(folder, name);
    const make = (): Buffer => {
      writeFileSync(plain, JSON.stringify({ type: 'FeatureCollection', features }));
      mkdirSync(folder);
      execFileSync('ogr2ogr', ['-f', driver, join(folder, name.replace('.dbf', '.shp')), plain], {
        stdio: 'ignore',
      });
      return readFileSync(path);
    };
    return target(
      `import-${name.slice(name.indexOf('.') + 1)}`,
      2,
      arbitraryDamage(1),
      async (input) => {
        good ??= make();
        writeFileSync(path, arrived([good], input));
        await acceptedOrRefused(['FISHNET'], () => readFishnet(path, source, {}, {}, kNever));
        await acceptedOrRefused(['POLYGON_FILE'], () => readPolygonFile(path, kNever));
      },
    );
  });
}
