import Feature from 'ol/Feature.js';
import Polygon from 'ol/geom/Polygon.js';
import VectorLayer from 'ol/layer/Vector.js';
import VectorSource from 'ol/source/Vector.js';
import Fill from 'ol/style/Fill.js';
import Stroke from 'ol/style/Stroke.js';
import Style from 'ol/style/Style.js';
import Text from 'ol/style/Text.js';
import { cssValue } from './dom.js';
import { hatchPattern, kStateSigns } from './patterns.js';
import {
  measureExtent,
  kSquareStates,
  squareContains,
  type Position,
  type Square,
  type SquareState,
} from './squares.js';

const kNameFromPx = 90;
const kLetterFromPx = 16;
// A square that fills the map is there to look at the ground: its frame and letter must do.
const kHatchToPx = 480;

/** LiDAR squares by state: hatch, letter and, when there is room, name. */
export class SquaresLayer {
  readonly layer = new VectorLayer({
    source: new VectorSource<Feature<Polygon>>({ wrapX: false }),
    zIndex: 4,
  });
  #squares: readonly Square[] = [];
  #hasHatch = true;
  #styles = stylesOfStates();

  constructor() {
    this.layer.setStyle((feature, resolution) => {
      const square = feature.get('square') as Square;
      const widthPx = (feature.get('width') as number) / resolution;
      const { hatched, framed } = this.#styles[square.state];
      const style = this.#hasHatch && widthPx <= kHatchToPx ? hatched : framed;
      const letter = widthPx >= kLetterFromPx ? kStateSigns[square.state].letter : '';
      style.getText()?.setText(widthPx >= kNameFromPx ? `${letter} ${square.name}` : letter);
      return style;
    });
  }

  set squares(squares: readonly Square[]) {
    this.#squares = squares;
    const source = this.layer.getSource();
    source?.clear(true);
    source?.addFeatures(
      squares.map((square) => {
        const [west, , east] = measureExtent(square);
        return new Feature({
          geometry: new Polygon(square.rings.map((ring) => ring.map((p) => [p[0], p[1]]))),
          square,
          width: east - west,
        });
      }),
    );
  }

  /** Without it the colours of what is below are not changed. */
  set hasHatch(hasHatch: boolean) {
    this.#hasHatch = hasHatch;
    this.layer.changed();
  }

  at(position: Position): Square | undefined {
    return this.#squares.find((square) => squareContains(square, position));
  }

  /** To be called when the colour scheme has changed. */
  recolour(): void {
    this.#styles = stylesOfStates();
    this.layer.changed();
  }
}

type Styles = Readonly<Record<SquareState, { readonly hatched: Style; readonly framed: Style }>>;

function stylesOfStates(): Styles {
  const halo = new Stroke({ color: cssValue('--back'), width: 4 });
  const ink = new Fill({ color: cssValue('--text') });
  const makeStyles = (state: SquareState): Styles[SquareState] => {
    const sign = kStateSigns[state];
    const colour = cssValue(sign.colour);
    const text = new Text({
      font: 'bold 13px system-ui, sans-serif',
      fill: ink,
      stroke: halo,
      overflow: true,
    });
    const framed = new Style({ stroke: new Stroke({ color: colour, width: 2.5 }), text });
    const hatched = framed.clone();
    hatched.setFill(new Fill({ color: hatchPattern(sign.hatch, colour) }));
    return { hatched, framed };
  };
  return Object.fromEntries(kSquareStates.map((state) => [state, makeStyles(state)])) as Styles;
}
