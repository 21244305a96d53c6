/**
 * What a tool is: a part of the panel, clicks into the picture, shapes over it, a share in how the
 * picture is drawn, and words in the link. A new tool is a file in tools/, its id in ToolId,
 * a line in toolbox.ts, and its texts.
 */
import type { World } from '../../replies.js';
import type { Appearance } from '../draw/appearance.js';
import type { Camera } from '../draw/look.js';
import type { Look } from '../draw/renderer.js';
import type { CastRay, Pick } from '../stage.js';
import type { Words } from './link.js';
import type { NumberText } from './number-text.js';
import type { Shape } from './overlay.js';
import type { Say } from './texts.js';

export type ToolId = 'measure' | 'profile' | 'section' | 'sight' | 'layers' | 'sun';

export type Tool = {
  readonly id: ToolId;
  readonly panel: readonly HTMLElement[];
  /** Somebody opens its panel. */
  begin?(): void;
  /** What lies under a click; a tool without it leaves clicks to the facts. */
  click?(pick: Pick): void;
  clear(): void;
  /** What is undefined is left out. */
  readonly shapes: () => readonly (Shape | undefined)[];
  /** Its share in how the picture is drawn. */
  look?(look: Look): Look;
  /** What had to be read for the view is there: rays may meet more now. */
  settled?(): void;
  timeChanged?(): void;
  /** Its state; none when it is as at the beginning. */
  words(): Words;
  /** Takes on a state; what is missing is as at the beginning. */
  follow(words: URLSearchParams): void;
};

/** What tools may use. */
export type ToolContext = {
  readonly say: Say;
  readonly numbers: NumberText;
  readonly world: World;
  readonly appearance: Appearance;
  cast(rays: readonly CastRay[]): readonly (Pick | undefined)[];
  camera(): Camera;
  /** Width by height. */
  aspect(): number;
  /** What is seen in the middle of the picture. */
  middle(): Pick | undefined;
  timeMs(): number;
  turnTo(headingDeg: number, pitchDeg: number): void;
  /** Shapes or words of a tool have changed. */
  changed(): void;
  /** Also its share in the look. */
  lookChanged(): void;
};

export type MakeTool = (context: ToolContext) => Tool;
