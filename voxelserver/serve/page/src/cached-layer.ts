import Feature from 'ol/Feature.js';
import MultiPolygon from 'ol/geom/MultiPolygon.js';
import { fromExtent } from 'ol/geom/Polygon.js';
import VectorLayer from 'ol/layer/Vector.js';
import VectorSource from 'ol/source/Vector.js';
import Fill from 'ol/style/Fill.js';
import Stroke from 'ol/style/Stroke.js';
import Style from 'ol/style/Style.js';
import { cssValue } from './dom.js';
import { hatchPattern, kDiskSign, kMemorySign, type Sign } from './patterns.js';
import type { CachedBoxes } from './squares.js';
import type { WorldProjection } from './world-projection.js';

/**
 * The boxes of one level that the server keeps, seen from above: those in memory hatched, those on
 * disk dotted, boxes in both with both patterns. One feature a kind, because a feature for each of
 * ten thousand boxes would be slow.
 */
export class CachedLayer {
  readonly layer = new VectorLayer({
    source: new VectorSource<Feature<MultiPolygon>>({ wrapX: false }),
    zIndex: 3,
  });
  readonly #projection: WorldProjection;
  readonly #memory = new Feature<MultiPolygon>();
  readonly #disk = new Feature<MultiPolygon>();

  constructor(projection: WorldProjection) {
    this.#projection = projection;
    this.layer.getSource()?.addFeatures([this.#disk, this.#memory]);
    this.recolour();
  }

  show(boxes: CachedBoxes): void {
    this.#memory.setGeometry(this.#shape(boxes.level, boxes.memory));
    this.#disk.setGeometry(this.#shape(boxes.level, boxes.disk));
  }

  recolour(): void {
    this.#memory.setStyle(chooseStyle(kMemorySign));
    this.#disk.setStyle(chooseStyle(kDiskSign));
  }

  #shape(level: number, boxes: CachedBoxes['memory']): MultiPolygon {
    const footprints = new Map(boxes.map(([bx, , bz]) => [`${bx} ${bz}`, [bx, bz] as const]));
    const extents = [...footprints.values()].map((key) =>
      this.#projection.boxExtent(level, ...key),
    );
    return new MultiPolygon(extents.map((extent) => fromExtent(extent)));
  }
}

function chooseStyle(sign: Sign): Style {
  const colour = cssValue(sign.colour);
  return new Style({
    fill: new Fill({ color: hatchPattern(sign.hatch, colour) }),
    stroke: new Stroke({ color: colour, width: 1.5 }),
  });
}
