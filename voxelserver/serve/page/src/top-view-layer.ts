import type ImageTile from 'ol/ImageTile.js';
import TileLayer from 'ol/layer/Tile.js';
import type Projection from 'ol/proj/Projection.js';
import TileImage from 'ol/source/TileImage.js';
import type Tile from 'ol/Tile.js';
import TileState from 'ol/TileState.js';
import TileGrid from 'ol/tilegrid/TileGrid.js';
import type { Api } from './http/api.js';
import type { WorldProjection } from './world-projection.js';

const kMostUnfinished = 512;
const kRetriesAtOnce = 6;

/**
 * The top view. Tiles are loaded by fetch, so that requests can carry a token and replies can state
 * whether a tile is whole. A tile that is not whole, or could not be fetched, is requested again by
 * retry(), and replaced in place, so that the map does not flicker.
 */
export class TopViewLayer {
  readonly layer: TileLayer<TileImage>;
  readonly #api: Api;
  readonly #source: TileImage;
  readonly #grid: TileGrid;
  readonly #unfinished = new Map<string, ImageTile>();
  #retrying = false;

  constructor(api: Api, projection: WorldProjection, mapProjection: Projection) {
    const { finestZoom, tilePx } = projection.world;
    this.#api = api;
    this.#grid = new TileGrid({
      origin: [0, 0],
      extent: projection.extent,
      resolutions: Array.from({ length: finestZoom + 1 }, (_, zoom) => projection.resolution(zoom)),
      tileSize: tilePx,
    });
    this.#source = new TileImage({
      projection: mapProjection,
      tileGrid: this.#grid,
      interpolate: false,
      wrapX: false,
      transition: 0,
      tileUrlFunction: ([z, x, y]) => `map/${z}/${x}/${y}.png`,
      tileLoadFunction: (tile, path) => void this.#load(tile as ImageTile, path),
    });
    this.layer = new TileLayer({ source: this.#source, zIndex: 1 });
  }

  /** Tiles of the current zoom that lie in view and are not whole, by path. */
  unfinishedIn(extent: number[], resolution: number): [string, ImageTile][] {
    const zoom = this.#grid.getZForResolution(resolution, this.#source.zDirection);
    const range = this.#grid.getTileRangeForExtentAndZ(extent, zoom);
    return [...this.#unfinished].filter(
      ([, tile]) =>
        tile.tileCoord[0] === zoom && range.containsXY(tile.tileCoord[1]!, tile.tileCoord[2]!),
    );
  }

  /** Forgets all tiles: the server is another, or now answers. */
  refresh(): void {
    this.#unfinished.clear();
    this.#source.refresh();
  }

  /** Requests the tiles of unfinishedIn() again. Calls while one runs do nothing. */
  async retry(extent: number[], resolution: number): Promise<void> {
    if (this.#retrying) return;
    this.#retrying = true;
    try {
      const due = this.unfinishedIn(extent, resolution);
      for (let i = 0; i < due.length; i += kRetriesAtOnce) {
        await Promise.all(
          due.slice(i, i + kRetriesAtOnce).map(([path, tile]) => this.#load(tile, path)),
        );
      }
    } finally {
      this.#retrying = false;
    }
  }

  async #load(tile: ImageTile, path: string): Promise<void> {
    try {
      const reply = await this.#api.get(path);
      const image = await createImageBitmap(new Blob([await reply.bytes()]));
      if (reply.headers.get('Terravox-Complete') === 'no') this.#remember(path, tile);
      else this.#unfinished.delete(path);
      // OpenLayers draws whatever a canvas draws.
      tile.setImage(image as unknown as HTMLImageElement);
    } catch {
      // The status line shows the state of the server. Tiles that are drawn already stay.
      this.#remember(path, tile);
      if (tile.getState() === TileState.LOADING) (tile as Tile).setState(TileState.ERROR);
    }
    this.layer.changed();
  }

  // The oldest go first: they are far from view, or they would have been retried.
  #remember(path: string, tile: ImageTile): void {
    this.#unfinished.delete(path);
    this.#unfinished.set(path, tile);
    const oldest = this.#unfinished.keys().next().value;
    if (this.#unfinished.size > kMostUnfinished && oldest !== undefined) {
      this.#unfinished.delete(oldest);
    }
  }
}
