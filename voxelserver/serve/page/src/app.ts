import { Api, toTrouble } from './http/api.js';
import { makeHttp } from './http/http.js';
import { Connection } from './connection.js';
import { Poller, wakeWhenShown } from './http/poller.js';
import { readStats, readWorld, type Stats } from './replies.js';
import { readSquares } from './squares.js';
import { StatsPanel } from './stats-panel.js';
import { tokenStore } from './token.js';
import { WorldView } from './world-view.js';

/**
 * The page: loads the facts of the world, then watches the server. Three polls: statistics,
 * squares, and unfinished tiles of the map.
 */

const kStatsMs = 1000;
const kSquaresMs = 10_000;
const kTilesMs = 3000;
const kQuietTilesS = 15; // unfinished tiles are requested again after this even if nothing was made

const nowS = (): number => performance.now() / 1000;

const api = new Api(document.baseURI, makeHttp(), tokenStore);
const statsPanel = new StatsPanel();
let worldText = '';
let mustLearnWorld = true; // also after each trouble: it may be another server that comes back
let view: WorldView | undefined;
let last: Stats | undefined;
let tilesAskedS = 0;
let tilesSeen = '';
let boxesSeen = '';

const connection = new Connection(api, () => {
  view?.refresh();
  statsPoll.wake();
  squaresPoll.wake();
});

// Another world behind the same address: everything on the page would be wrong, so it starts anew.
async function learnWorld(): Promise<void> {
  const json = await api.getJson('v2/world');
  const text = JSON.stringify(json);
  if (worldText !== '' && text !== worldText) return location.reload();
  worldText = text;
  if (view !== undefined) return;
  view = new WorldView(api, readWorld(json));
  squaresPoll.wake();
  tilesPoll.wake();
}

async function watch(): Promise<void> {
  try {
    if (mustLearnWorld) await learnWorld();
    mustLearnWorld = false;
    const stats = readStats(await api.getJson('v2/stats'));
    // The server was restarted so quickly that no poll noticed.
    if (last !== undefined && stats.uptimeS < last.uptimeS) {
      await learnWorld();
      view?.refresh();
    }
    last = stats;
    statsPanel.update(stats);
    view?.update(stats);
    connection.well();
    const seen = [
      stats.cache?.entries,
      stats.disk?.entries,
      stats.making?.made,
      stats.cache?.evictions,
    ].join();
    if (seen !== boxesSeen) void view?.updateBoxes(false);
    boxesSeen = seen;
  } catch (error) {
    mustLearnWorld = true;
    connection.trouble(error);
    throw error;
  }
}

async function learnSquares(): Promise<void> {
  if (view === undefined) return;
  try {
    view.squares = readSquares(await api.getJson('v2/squares'));
  } catch (error) {
    // A server without squares (another kind of world) is no error; the statistics' poll reports
    // all
    // others.
    if (toTrouble(error) === 'missing') view.squares = [];
    else throw error;
  }
}

async function retryTiles(): Promise<void> {
  const made = (last?.making?.made ?? 0) + (last?.making?.madeAhead ?? 0);
  const seen = `${made} ${view?.shown ?? ''}`;
  if (seen === tilesSeen && nowS() - tilesAskedS < kQuietTilesS) return;
  tilesSeen = seen;
  tilesAskedS = nowS();
  await view?.retryTiles();
}

const statsPoll = new Poller(kStatsMs, watch);
const squaresPoll = new Poller(kSquaresMs, learnSquares);
const tilesPoll = new Poller(kTilesMs, retryTiles);

wakeWhenShown(statsPoll, squaresPoll, tilesPoll);
window
  .matchMedia('(prefers-color-scheme: dark)')
  .addEventListener('change', () => view?.recolour());
statsPoll.wake();
