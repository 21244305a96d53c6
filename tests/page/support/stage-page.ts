/** Bundled for a browser: a Stage alone on a canvas, with pools of a size that the test chooses. */
import type { Place } from '../../../voxelserver/serve/page/src/viewer/data/protocol.js';
import type {
  Appearance,
  Face,
  Rgb,
} from '../../../voxelserver/serve/page/src/viewer/draw/appearance.js';
import { Stage, type StageStats } from '../../../voxelserver/serve/page/src/viewer/stage.js';
import {
  toCamera,
  type Viewpoint,
} from '../../../voxelserver/serve/page/src/viewer/ui/navigation.js';

export type StageJob = {
  readonly place: Place;
  readonly view: Viewpoint;
  readonly poolBytes: number;
  /** Of the canvas, pixels. */
  readonly side?: number;
};

declare global {
  // Only an interface merges with the one that is there.
  // eslint-disable-next-line @typescript-eslint/consistent-type-definitions
  interface Window {
    startStage: (job: StageJob) => void;
    stage: {
      readonly failures: string[];
      readonly ended: string[];
      readonly isReady: () => boolean;
      readonly stats: () => StageStats;
      readonly setView: (view: Viewpoint) => void;
      readonly hits: () => Int32Array;
      /** Of the middle of the canvas. */
      readonly colour: () => readonly number[];
    };
  }
}

const kHalfOne = 0x3c00;
const kSide = 120;

function plainAppearance(): Appearance {
  const one: Rgb = [1, 1, 1];
  const none: Rgb = [0, 0, 0];
  const face: Face = {
    first: 0,
    ownFirst: 0,
    variants: 0,
    turns: 0,
    metric: false,
    layered: false,
    hasOwn: false,
    hasHoles: false,
  };
  const material = (_: unknown, i: number) => ({
    name: `material ${i}`,
    kind: 0,
    colour: one,
    variation: 0,
    roughness: 1,
    index: 1,
    reflects: false,
    absorption_per_m: none,
    glow: none,
    emission: none,
    own: none,
    windows: false,
    waves: false,
    side: face,
    bottom: face,
    top: face,
  });
  const sky = {
    altitudes_deg: [-90, 90],
    rows: 2,
    columns: 2,
    sunAltitudes_deg: [-90, 90],
    sunLight: [one, one],
    hazeRayleigh_per_m: none,
    hazeMie_per_m: none,
    night: none,
    ground: one,
  };
  return {
    materials: Array.from({ length: 33 }, material),
    sky,
    ratio: new Uint16Array(4 * 341).fill(kHalfOne),
    own: new Uint16Array(4 * 341),
    panes: new Uint16Array(8 * 341 * 8),
    skyNodes: new Uint16Array(2 * 2 * 2 * 9).fill(kHalfOne),
  };
}

window.startStage = ({ place, view, poolBytes, side = kSide }) => {
  const canvas = document.querySelector('canvas')!;
  canvas.width = side;
  canvas.height = side;
  const failures: string[] = [];
  const ended: string[] = [];
  let isReady = false;
  const worker = new Worker('worker.js', { type: 'module' });
  const stage = new Stage(canvas, worker, place, plainAppearance(), poolBytes, {
    onOpened: () => undefined,
    onFailure: (failure) => void failures.push(failure.kind),
    onEnded: (failure) => void ended.push(`${failure.kind}: ${failure.message}`),
    onFrame: () => undefined,
  });
  stage.ready.then(
    () => (isReady = true),
    () => undefined,
  );
  stage.setTime(Date.UTC(2026, 5, 21, 12));
  stage.setCamera(toCamera(view));
  const frame = (nowMs: number): void => {
    stage.frame(nowMs);
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
  window.stage = {
    failures,
    ended,
    isReady: () => isReady,
    stats: () => stage.stats(),
    setView: (wanted) => stage.setCamera(toCamera(wanted)),
    hits: () => stage.firstHits()!.voxels,
    colour: () => {
      const copy = new OffscreenCanvas(side, side).getContext('2d')!;
      copy.drawImage(canvas, 0, 0);
      return [...copy.getImageData(side / 2, side / 2, 1, 1).data];
    },
  };
};
