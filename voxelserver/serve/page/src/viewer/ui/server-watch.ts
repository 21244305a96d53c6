/** What the viewer shows of a voxel server: how far it is with what is missing, and its map. */
import { Api, toTrouble } from '../../http/api.js';
import type { Http } from '../../http/http.js';
import { placeToHash } from '../../coordinates.js';
import { byId, element, setText } from '../../dom.js';
import { Poller, wakeWhenShown } from '../../http/poller.js';
import { readStats, readWorld, type Stats, type World } from '../../replies.js';
import { computeForward, type Viewpoint } from './navigation.js';
import { tokenStore } from '../../token.js';
import type { Say } from './texts.js';

const kEveryMs = 2000;
const kMapPixels = 512; // as many pixels of the map as what is looked at is away
const kNearest = 200; // voxels
const kFarthest = 5000;
const kDecimals = 2;

export type WatchedViewer = {
  readonly view: Viewpoint;
  readonly stage: { stats(): { readonly waiting: number; readonly frames: number } };
};

/** @param server its address */
export function watchServer(http: Http, server: string, say: Say, viewer: WatchedViewer): void {
  const api = new Api(server, http, tokenStore);
  const line = element('p', { id: 'server', role: 'status' });
  byId('status', HTMLParagraphElement).after(line);
  byId('panel', HTMLDivElement).prepend(element('p', {}, mapLink(api, say, viewer)));
  const watch = async (): Promise<void> => {
    const { waiting, frames } = viewer.stage.stats();
    try {
      const isIdle = waiting === 0 && frames > 0;
      setText(line, isIdle ? '' : describeProgress(readStats(await api.getJson('v2/stats')), say));
    } catch (error) {
      setText(line, describeTrouble(error, say));
      throw error;
    }
  };
  const poll = new Poller(kEveryMs, watch);
  wakeWhenShown(poll);
  poll.wake();
}

/** One sentence; empty where the server makes nothing. */
export function describeProgress({ making, prepare }: Stats, say: Say): string {
  const parts: string[] = [];
  if (making !== undefined && making.running + making.waiting > 0) {
    parts.push(
      say('serverMaking', String(making.running), String(making.waiting), String(making.made)),
    );
  }
  if (prepare !== undefined && prepare.done < prepare.total) {
    parts.push(say('serverPrepares', String(prepare.done), String(prepare.total)));
  }
  if (making !== undefined && making.failed > 0) {
    parts.push(say('serverFailed', String(making.failed)));
  }
  return parts.join('; ');
}

function describeTrouble(error: unknown, say: Say): string {
  const kind = toTrouble(error);
  if (kind === 'token') return say('serverToken');
  if (kind === 'busy') return say('serverBusy');
  return say('serverGone');
}

// To the map at the place that is looked at; without the facts of the world, to all of it.
function mapLink(api: Api, say: Say, viewer: WatchedViewer): HTMLAnchorElement {
  const link = element('a', { id: 'map-link', href: api.base }, say('map'));
  const followView = (json: unknown): void => {
    const world = readWorld(json);
    link.addEventListener('click', () => {
      link.href = new URL(placeOnMap(viewer.view, world), api.base).href;
    });
  };
  api.getJson('v2/world').then(followView, () => undefined);
  return link;
}

/**
 * Where the line of sight meets the world's middle height, or what is under the camera where it
 * does not or far away.
 */
export function placeOnMap(view: Viewpoint, { framed, unitsPerVoxel }: World): string {
  const [x, y, z] = view.position;
  const forward = computeForward(view);
  const along = ((framed.min[1] + framed.max[1]) / 2 - y) / forward[1];
  const away = along > 0 && along < kFarthest ? along : 0;
  const resolution = (Math.max(away, kNearest) * unitsPerVoxel) / kMapPixels;
  const easting = (x + away * forward[0]) * unitsPerVoxel;
  const northing = -(z + away * forward[2]) * unitsPerVoxel;
  return placeToHash(easting, northing, resolution, kDecimals);
}
