import type { Vec2 } from './vec3.js';
import ScaleLine from 'ol/control/ScaleLine.js';
import Zoom from 'ol/control/Zoom.js';
import { buffer, createEmpty, extend, getHeight, getWidth, isEmpty } from 'ol/extent.js';
import Feature from 'ol/Feature.js';
import Point from 'ol/geom/Point.js';
import { defaults as defaultInteractions } from 'ol/interaction/defaults.js';
import VectorLayer from 'ol/layer/Vector.js';
import OlMap from 'ol/Map.js';
import Projection from 'ol/proj/Projection.js';
import VectorSource from 'ol/source/Vector.js';
import CircleStyle from 'ol/style/Circle.js';
import Stroke from 'ol/style/Stroke.js';
import Style from 'ol/style/Style.js';
import View from 'ol/View.js';
import type { WorldProjection } from './world-projection.js';

export type MapEvents = {
  /** A click, or Enter on the map: then the middle. */
  readonly onPick: (easting: number, northing: number) => void;
  /** The pointer is over a place, or (undefined) left the map. */
  readonly onPointer: (place: Vec2 | undefined) => void;
  /** The view came to rest. */
  readonly onMoved: () => void;
};

/** The map itself, in the world's own CRS: what is straight there is straight here. */
export class MapView {
  readonly map: OlMap;
  readonly mapProjection: Projection;
  readonly #view: View;
  readonly #marker = new Feature<Point>();
  readonly #worldExtent: number[];
  readonly #framedExtent: number[];

  constructor(target: HTMLElement, projection: WorldProjection, events: MapEvents) {
    const { unitsPerVoxel, crs } = projection.world;
    // OpenLayers only needs the length of a unit: WorldProjection handles latitude and longitude.
    this.mapProjection = new Projection({
      code: crs === '' ? 'world' : crs,
      units: 'm',
      metersPerUnit: projection.metresPerUnit,
      getPointResolution: (resolution) => resolution * projection.metresPerUnit,
    });
    this.#worldExtent = [...projection.extent];
    this.#framedExtent = [...projection.framedExtent];
    const side = Math.max(getWidth(this.#worldExtent), getHeight(this.#worldExtent), unitsPerVoxel);
    this.#view = new View({
      projection: this.mapProjection,
      center: projection.centre(),
      resolution: side / 512,
      minResolution: unitsPerVoxel / 16,
      maxResolution: Math.max(side / 64, unitsPerVoxel),
      extent: buffer(this.#worldExtent, side / 2),
      constrainOnlyCenter: true,
      enableRotation: false,
    });
    this.map = new OlMap({
      target,
      view: this.#view,
      controls: [
        new Zoom({ zoomInTipLabel: 'Zoom in', zoomOutTipLabel: 'Zoom out' }),
        new ScaleLine({ units: 'metric', minWidth: 80 }),
      ],
      interactions: defaultInteractions({ altShiftDragRotate: false, pinchRotate: false }),
      layers: [this.#markerLayer()],
    });
    this.#listen(target, events);
  }

  /** Shows all of an extent; by default the first view of the world. */
  fit(extent: readonly number[] = this.#framedExtent): void {
    this.map.updateSize();
    if (!isEmpty([...extent])) this.#view.fit([...extent], { padding: [24, 24, 40, 24] });
  }

  goTo(easting: number, northing: number, resolution?: number): void {
    this.#view.setCenter([easting, northing]);
    if (resolution !== undefined) this.#view.setResolution(resolution);
  }

  /** A ring around the place that the panel describes. */
  mark(easting: number, northing: number): void {
    this.#marker.setGeometry(new Point([easting, northing]));
  }

  get centre(): [number, number] {
    const [e, n] = this.#view.getCenter() ?? [0, 0];
    return [e ?? 0, n ?? 0];
  }
  get resolution(): number {
    return this.#view.getResolution() ?? 1;
  }
  get shownExtent(): number[] {
    return extend(createEmpty(), this.#view.calculateExtent(this.map.getSize() ?? [1, 1]));
  }

  #markerLayer(): VectorLayer {
    const ring = (color: string, width: number): Style =>
      new Style({ image: new CircleStyle({ radius: 9, stroke: new Stroke({ color, width }) }) });
    return new VectorLayer({
      source: new VectorSource({ features: [this.#marker], wrapX: false }),
      style: [ring('#fff', 6), ring('#c2185b', 3)],
      zIndex: 9,
    });
  }

  #listen(target: HTMLElement, events: MapEvents): void {
    this.map.on('click', ({ coordinate: [e, n] }) => events.onPick(e ?? 0, n ?? 0));
    this.map.on('pointermove', ({ coordinate: [e, n] }) => events.onPointer([e ?? 0, n ?? 0]));
    this.map.on('moveend', () => events.onMoved());
    target.addEventListener('pointerleave', () => events.onPointer(undefined));
    target.addEventListener('keydown', (event) => {
      // On the zoom buttons Enter presses the button.
      if (event.key === 'Enter' && event.target === target) events.onPick(...this.centre);
    });
  }
}
