import type { Vec2 } from './vec3.js';
import { getIntersection, isEmpty } from 'ol/extent.js';
import { AnalysisLayer } from './analysis-layer.js';
import { AnalysisPanel } from './analysis-panel.js';
import type { Api } from './http/api.js';
import { CachedLayer } from './cached-layer.js';
import { decimalsFor, formatLatLon, placeFromHash } from './coordinates.js';
import { byId, setFacts, setText, toOptions } from './dom.js';
import { formatCount } from './number-format.js';
import { MapView } from './map-view.js';
import { PlacePanel } from './place-panel.js';
import type { Stats, World } from './replies.js';
import { setUpSearch } from './search-form.js';
import { SquaresLayer } from './squares-layer.js';
import { SquaresTable } from './squares-table.js';
import { measureExtent, readCachedBoxes, type CachedBoxes, type Square } from './squares.js';
import { TopViewLayer } from './top-view-layer.js';
import { viewOfMap } from './view-link.js';
import { WorldProjection } from './world-projection.js';

const kPlaceVoxels = 400; // shown across 512 pixels when the map moves to a place

/** The map with its layers and panels: the whole page once the world is known. */
export class WorldView {
  readonly #api: Api;
  readonly #projection: WorldProjection;
  readonly #map: MapView;
  readonly #topView: TopViewLayer | undefined;
  readonly #squares = new SquaresLayer();
  readonly #cached: CachedLayer;
  readonly #table: SquaresTable;
  readonly #place: PlacePanel;
  readonly #analyses: AnalysisPanel;
  #picked: Vec2 | undefined;
  #level = 0;
  #showsBoxes = false;
  #boxes: CachedBoxes | undefined;

  constructor(api: Api, world: World) {
    this.#api = api;
    const projection = new WorldProjection(world);
    this.#projection = projection;
    document.body.classList.remove('waiting');
    showWorld(world);
    this.#place = new PlacePanel(api, projection);
    this.#map = new MapView(byId('map', HTMLElement), projection, {
      onPick: (e, n) => void this.#pick(e, n),
      onPointer: (place) => this.#showPosition(place),
      onMoved: () => {
        this.#showPosition(undefined);
        this.#linkView();
        this.#placeAnalyses();
      },
    });
    this.#topView =
      world.finestZoom >= 0
        ? new TopViewLayer(api, projection, this.#map.mapProjection)
        : undefined;
    this.#cached = new CachedLayer(projection);
    this.#cached.layer.setVisible(false);
    const analyses = new AnalysisLayer(this.#map.mapProjection, projection);
    const others = [this.#squares.layer, this.#cached.layer, analyses.layer];
    const layers = this.#topView ? [this.#topView.layer, ...others] : others;
    for (const layer of layers) this.#map.map.addLayer(layer);
    analyses.layer.on(
      'change:visible',
      () => (this.#squares.hasHatch = !analyses.layer.getVisible()),
    );
    const places = { isPlaced: world.crs !== '', unitsPerVoxel: world.unitsPerVoxel };
    this.#analyses = new AnalysisPanel(api, world.centre !== undefined, places, analyses);
    this.#setUpLayers(world.levels);
    this.#table = new SquaresTable((square) => this.#goToSquare(square));
    setUpSearch(
      () => projection,
      ({ easting, northing }) => this.#goTo(easting, northing),
    );
    this.#map.fit();
    this.#openHash();
    window.addEventListener('hashchange', () => this.#openHash());
  }

  set squares(squares: readonly Square[]) {
    this.#squares.squares = squares;
    this.#table.squares = squares;
  }

  /**
   * Requests the kept boxes if they are shown.
   * @param always also when the view has not changed
   */
  async updateBoxes(always: boolean): Promise<void> {
    if (!this.#showsBoxes) return;
    const level = this.#level;
    try {
      const boxes = readCachedBoxes(await this.#api.getJson(`v2/cached/${level}`));
      if (level !== this.#level || !this.#showsBoxes) return;
      if (!always && boxes.level === this.#boxes?.level && boxes.changes === this.#boxes.changes) {
        return;
      }
      this.#boxes = boxes;
      this.#cached.show(boxes);
      const counts = [boxes.memory, boxes.disk].map((list) => formatCount(list.length));
      const rest = boxes.truncated ? ' (more than are drawn)' : '';
      this.#noteBoxes(`${counts[0]} in memory, ${counts[1]} on disk${rest}`);
    } catch {
      if (level === this.#level) this.#noteBoxes('The kept boxes could not be loaded.');
    }
  }

  /** Changes when the map shows something else. */
  get shown(): string {
    return this.#map.shownExtent.join();
  }

  /** Requests the unfinished tiles of the top view again. */
  async retryTiles(): Promise<void> {
    await this.#topView?.retry(this.#map.shownExtent, this.#map.resolution);
  }

  update(stats: Stats): void {
    const { shownExtent, resolution } = this.#map;
    const unfinished = this.#topView?.unfinishedIn(shownExtent, resolution).length ?? 0;
    setText(
      byId('top-note', HTMLElement),
      unfinished === 0 ? '' : 'Some of it is not made yet. Zoom in to have it made.',
    );
    this.#analyses.limits = stats.jobs;
    setText(byId('software', HTMLElement), `Terravox ${stats.version}`);
  }

  /** The server came back, or another was started in its place. */
  refresh(): void {
    this.#topView?.refresh();
    void this.updateBoxes(true);
  }

  recolour(): void {
    this.#squares.recolour();
    this.#cached.recolour();
  }

  #setUpLayers(levels: number): void {
    const onSwitch = (name: string, run: (shown: boolean) => void): void => {
      const box = byId(`layer-${name}`, HTMLInputElement);
      box.addEventListener('change', () => run(box.checked));
    };
    onSwitch('top', (shown) => this.#topView?.layer.setVisible(shown));
    onSwitch('squares', (shown) => this.#squares.layer.setVisible(shown));
    onSwitch('boxes', (shown) => this.#showBoxes(shown));
    byId('layer-top', HTMLInputElement).parentElement!.hidden = this.#topView === undefined;
    const level = byId('level', HTMLSelectElement);
    const names = Array.from({ length: levels }, (_, i) => `${i}: voxels of ${2 ** i}`);
    level.append(...toOptions(names.map((name, i) => [String(i), name])));
    level.addEventListener('change', () => {
      this.#level = Number(level.value);
      void this.updateBoxes(true);
    });
  }

  #showBoxes(shown: boolean): void {
    this.#showsBoxes = shown;
    this.#cached.layer.setVisible(shown);
    if (!shown) {
      this.#boxes = undefined;
      this.#noteBoxes('');
    }
    void this.updateBoxes(true);
  }

  #noteBoxes(text: string): void {
    setText(byId('boxes-note', HTMLElement), text);
  }

  async #pick(easting: number, northing: number): Promise<void> {
    this.#map.mark(easting, northing);
    this.#picked = [easting, northing];
    this.#placeAnalyses();
    await this.#place.show(
      easting,
      northing,
      this.#map.resolution,
      this.#squares.at([easting, northing]),
    );
  }

  #goTo(easting: number, northing: number, resolution?: number): void {
    const near = (kPlaceVoxels * this.#projection.world.unitsPerVoxel) / 512;
    this.#map.goTo(easting, northing, resolution ?? Math.min(this.#map.resolution, near));
    void this.#pick(easting, northing);
  }

  #goToSquare(square: Square): void {
    const [west, south, east, north] = measureExtent(square);
    this.#map.fit([west, south, east, north]);
    void this.#pick((west + east) / 2, (south + north) / 2);
  }

  #openHash(): void {
    const place = placeFromHash(location.hash);
    if (place) this.#goTo(place.easting, place.northing, place.resolution);
  }

  #linkView(): void {
    const [west, south, east, north] = this.#map.shownExtent;
    const across = Math.min(east! - west!, north! - south!);
    byId('view-link', HTMLAnchorElement).href = new URL(
      viewOfMap(this.#map.centre, across, this.#projection),
      this.#api.base,
    ).href;
  }

  #placeAnalyses(): void {
    const shown = getIntersection(this.#map.shownExtent, this.#projection.extent);
    const { world, metresPerUnit } = this.#projection;
    const extent = isEmpty(shown) ? undefined : shown;
    const clockOffsetH =
      extent && this.#projection.clockOffsetH(extent as [number, number, number, number]);
    this.#analyses.place = {
      extent,
      voxelM: world.voxelM,
      metresPerUnit,
      clockOffsetH,
      picked: this.#picked,
    };
  }

  // Without a pointer (keyboard, touch) it is the middle of the map that counts.
  #showPosition(place: Vec2 | undefined): void {
    const [e, n] = place ?? this.#map.centre;
    this.#analyses.pointAt(e, n);
    const decimals = decimalsFor(this.#projection.world.unitsPerVoxel);
    const latLon = this.#projection.toLatLon(e, n);
    const texts = [
      `${e.toFixed(decimals)}, ${n.toFixed(decimals)}`,
      ...(latLon ? [formatLatLon(latLon)] : []),
    ];
    setText(byId('position', HTMLElement), `${place ? '' : 'Middle: '}${texts.join('  ·  ')}`);
  }
}

function showWorld(world: World): void {
  const title = world.title === '' ? 'A world' : world.title;
  setText(byId('title', HTMLElement), title);
  document.title = `${title} – Terravox voxel server`;
  setText(byId('attribution', HTMLElement), world.attribution);
  const size = (axis: 0 | 1 | 2): string => String(world.max[axis] - world.min[axis]);
  setFacts(byId('world', HTMLDListElement), [
    ['CRS', world.crs === '' && world.crsWkt === '' ? 'none: coordinates of its own' : world.crs],
    ['Voxel', `${world.voxelM} m`],
    ['Size', `${size(0)} × ${size(2)} voxels, ${size(1)} high`],
    ['Levels', `0 to ${world.levels - 1}`],
    ['Licence', world.licence],
    ['Attribution', world.attribution],
  ]);
}
