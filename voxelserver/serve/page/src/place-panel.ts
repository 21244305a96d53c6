import type { Vec2 } from './vec3.js';
import { toMessage, type Api } from './http/api.js';
import { decimalsFor, formatLatLon, placeToHash } from './coordinates.js';
import { byId, copyOnClick, setFacts, setText } from './dom.js';
import { formatBytes, formatCount } from './number-format.js';
import type { Square } from './squares.js';
import { findTop, type Top } from './top-finder.js';
import { inTheMiddle, placeCamera, renderCommand, viewLink } from './view-link.js';
import type { WorldProjection } from './world-projection.js';

/**
 * What is at a place: coordinates, what is on top, the LiDAR square, and the command that renders
 * it.
 */
export class PlacePanel {
  readonly #api: Api;
  readonly #projection: WorldProjection;
  readonly #command = byId('command', HTMLTextAreaElement);
  #place: Vec2 = [0, 0];
  #height: number | undefined;
  #resolution = 1;
  #shown = 0;

  constructor(api: Api, projection: WorldProjection) {
    this.#api = api;
    this.#projection = projection;
    const copied: Readonly<Record<string, () => string>> = {
      'copy-place': () => this.#placeText(),
      'copy-degrees': () => this.#latLonText(),
      'copy-link': () => this.#link(),
      'copy-command': () => this.#command.value,
    };
    for (const [id, content] of Object.entries(copied)) {
      copyOnClick(byId(id, HTMLButtonElement), content);
    }
  }

  /** Shows a place: known facts at once, then, with the reply of the server, what is on top. */
  async show(
    easting: number,
    northing: number,
    resolution: number,
    square: Square | undefined,
  ): Promise<void> {
    this.#shown += 1;
    const mine = this.#shown;
    this.#place = [easting, northing];
    this.#height = undefined;
    this.#resolution = resolution;
    byId('place', HTMLElement).hidden = false;
    const where = square ? `square ${square.name}, ${square.state}` : 'in no LiDAR square';
    setText(byId('place-summary', HTMLElement), `${this.#placeText()}: ${where}`);
    this.#draw(square, 'looking …');
    this.#note('The height is being looked up …');
    this.#command.value = '';
    const about = inTheMiddle({ easting, northing }, this.#projection);
    const camera = placeCamera(about, this.#projection);
    this.#linkView(viewLink(about, camera, this.#projection));
    try {
      const top = await findTop(this.#api, this.#projection, easting, northing);
      // This height only keeps the camera out of hills: without it the command is still useful.
      const ground = await findTop(
        this.#api,
        this.#projection,
        camera.easting,
        camera.northing,
      ).catch(() => undefined);
      if (mine !== this.#shown) return;
      this.#height = top?.heightM;
      const { materials } = this.#projection.world;
      this.#draw(square, top ? describe(top, materials) : 'nothing: only air here');
      this.#propose(top?.heightM, ground?.heightM, square);
    } catch (error) {
      if (mine !== this.#shown) return;
      this.#draw(square, 'unknown');
      const what = `The top of this place could not be loaded. ${toMessage(error)}`;
      this.#note(`${what} Choose the place again to retry.`);
    }
  }

  #propose(
    heightM: number | undefined,
    groundM: number | undefined,
    square: Square | undefined,
  ): void {
    if (heightM === undefined) return this.#note('Nothing to render here.');
    const [easting, northing] = this.#place;
    const target = { easting, northing, heightM };
    const from = placeCamera(target, this.#projection, groundM);
    const server = this.#api.base.replace(/\/$/, '');
    const name = square?.name ?? 'picture';
    this.#command.value = renderCommand(server, target, from, name, this.#projection);
    this.#linkView(viewLink(target, from, this.#projection));
    this.#note('Seen from the south-west, 400 m away.');
  }

  #note(text: string): void {
    setText(byId('command-note', HTMLElement), text);
  }

  #linkView(link: string): void {
    byId('place-view', HTMLAnchorElement).href = new URL(link, this.#api.base).href;
  }

  #draw(square: Square | undefined, top: string): void {
    const { crs } = this.#projection.world;
    const latLon = this.#latLonText();
    const geo = byId('place-geo', HTMLAnchorElement);
    for (const part of [byId('copy-degrees', HTMLElement), geo]) part.hidden = latLon === '';
    geo.href = `geo:${latLon.replace(' ', '')}`;
    setFacts(byId('place-facts', HTMLDListElement), [
      [crs === '' ? 'Easting, northing' : crs, this.#placeText()],
      ['Latitude, longitude', latLon],
      ['On top', top],
      ...toFacts(square),
    ]);
  }

  #placeText(): string {
    const decimals = decimalsFor(this.#projection.world.unitsPerVoxel);
    return [
      ...this.#place.map((value) => value.toFixed(decimals)),
      ...(this.#height === undefined ? [] : [this.#height.toFixed(2)]),
    ].join(',');
  }

  #latLonText(): string {
    const place = this.#projection.toLatLon(...this.#place);
    return place ? formatLatLon(place) : '';
  }

  #link(): string {
    const decimals = decimalsFor(this.#projection.world.unitsPerVoxel);
    return new URL(placeToHash(...this.#place, this.#resolution, decimals), this.#api.base).href;
  }
}

function describe(top: Top, materials: readonly string[]): string {
  const height = `${top.heightM.toFixed(2)} m`;
  if (top.look === undefined) return height;
  const { material, colour } = top.look;
  const name = materials[material]?.replaceAll('_', ' ') ?? `material ${material}`;
  const hex = colour?.map((part) => part.toString(16).padStart(2, '0')).join('');
  return `${name}, ${height}${hex === undefined ? '' : `, #${hex}`}`;
}

const shown = (value: number | undefined, format: (value: number) => string): string =>
  value === undefined ? '' : format(value);

/** Rows about a square; those with an empty text are not shown. */
function toFacts(square: Square | undefined): [string, string][] {
  if (square === undefined) return [];
  const { file, bytes, points, densityPerM2 } = square;
  return [
    ['Square', square.name],
    ['State', square.state],
    ['Error', square.error],
    ['File', [file, shown(bytes, formatBytes)].filter((text) => text !== '').join(', ')],
    ['Points', shown(points, formatCount)],
    ['Density', shown(densityPerM2, (value) => `${value.toFixed(1)} points a square metre`)],
    ['Source', square.source],
    ['Licence', square.licence],
    ['Attribution', square.attribution],
  ];
}
