import type { Vec2 } from './vec3.js';
import { toMessage, type Api } from './http/api.js';
import { decimalsFor, formatLatLon, placeToHash } from './coordinates.js';
import { buttonRow, byId, copyButton, element, setFacts, setText } from './dom.js';
import { formatBytes, formatCount } from './number-format.js';
import { cameraHeight, cameraPlace, renderCommand } from './render-command.js';
import type { Square } from './squares.js';
import { TopFinder, type Top } from './top-finder.js';
import { viewLink, viewOfPlace } from './view-link.js';
import type { WorldProjection } from './world-projection.js';

/**
 * What is at a place: coordinates, what is on top, the LiDAR square, and the command that renders
 * it.
 */
export class PlacePanel {
  readonly #api: Api;
  readonly #projection: WorldProjection;
  readonly #tops: TopFinder;
  readonly #summary = byId('place-summary', HTMLElement);
  readonly #facts = element('dl');
  readonly #command = element('textarea', {
    id: 'command',
    readonly: '',
    rows: '5',
    spellcheck: 'false',
  });
  readonly #note = element('p', { class: 'note' });
  readonly #latLonButton: HTMLButtonElement;
  readonly #geo = element('a', {}, 'Open in a map program');
  readonly #view = element('a', {}, 'View in 3D');
  #place: Vec2 = [0, 0];
  #height: number | undefined;
  #resolution = 1;
  #shown = 0;

  constructor(api: Api, projection: WorldProjection) {
    this.#api = api;
    this.#projection = projection;
    this.#tops = new TopFinder(api, projection);
    this.#latLonButton = copyButton('Copy lat, lon', () => this.#latLonText());
    const buttons = buttonRow(
      copyButton('Copy E,N', () => this.#placeText()),
      this.#latLonButton,
      copyButton('Copy link', () => this.#link()),
      this.#view,
      this.#geo,
    );
    const label = element('label', { for: 'command' }, 'Render it');
    const copyCommand = copyButton('Copy command', () => this.#command.value);
    const parts = [label, this.#command, copyCommand, this.#note];
    const command = element('div', { class: 'command' }, ...parts);
    byId('place', HTMLElement).append(this.#facts, buttons, command);
    byId('place', HTMLElement).hidden = true;
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
    setText(this.#summary, `${this.#placeText()}: ${where}`);
    this.#draw(square, 'looking …');
    setText(this.#note, 'The height is being looked up …');
    this.#command.value = '';
    const camera = cameraPlace({ easting, northing }, this.#projection);
    try {
      const top = await this.#tops.find(easting, northing);
      // This height only keeps the camera out of hills: without it the command is still useful.
      const ground = await this.#tops.find(...camera).catch(() => undefined);
      if (mine !== this.#shown) return;
      this.#height = top?.heightM;
      this.#draw(
        square,
        top ? describe(top, this.#projection.world.materials) : 'nothing: only air here',
      );
      this.#propose(camera, top, ground, square);
    } catch (error) {
      if (mine !== this.#shown) return;
      this.#draw(square, 'unknown');
      const what = `The top of this place could not be loaded. ${toMessage(error)}`;
      setText(this.#note, `${what} Choose the place again to retry.`);
    }
  }

  #propose(
    camera: Vec2,
    top: Top | undefined,
    ground: Top | undefined,
    square: Square | undefined,
  ): void {
    if (top === undefined) return setText(this.#note, 'Nothing to render here.');
    const [easting, northing] = this.#place;
    const target = { easting, northing, heightM: top.heightM };
    const from = {
      easting: camera[0],
      northing: camera[1],
      heightM: cameraHeight(top.heightM, ground?.heightM),
    };
    this.#command.value = renderCommand(
      this.#api.base.replace(/\/$/, ''),
      target,
      from,
      square?.name ?? 'picture',
      this.#projection,
    );
    this.#linkView(viewLink(target, from, this.#projection));
    setText(this.#note, 'Seen from the south-west, 400 m away.');
  }

  #linkView(link: string): void {
    this.#view.href = new URL(link, this.#api.base).href;
  }

  #draw(square: Square | undefined, top: string): void {
    const { crs } = this.#projection.world;
    const latLon = this.#latLonText();
    for (const part of [this.#latLonButton, this.#geo]) part.hidden = latLon === '';
    this.#geo.setAttribute('href', `geo:${latLon.replace(' ', '')}`);
    const [easting, northing] = this.#place;
    this.#linkView(viewOfPlace({ easting, northing }, this.#height, this.#projection));
    setFacts(this.#facts, [
      [crs === '' ? 'Easting, northing' : `${crs}`, this.#placeText()],
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
    return place ? formatLatLon(place.latDeg, place.lonDeg) : '';
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
export function toFacts(square: Square | undefined): [string, string][] {
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
