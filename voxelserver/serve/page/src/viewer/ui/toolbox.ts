/** All tools: their buttons, the one whose panel is open, and what they add to picture and link. */
import { button, element } from '../../dom.js';
import type { Look } from '../draw/renderer.js';
import type { Pick } from '../stage.js';
import type { Words } from './link.js';
import type { Shape } from './overlay.js';
import type { MakeTool, Tool, ToolContext } from './tool.js';
import { makeLayers } from './tools/layers.js';
import { makeMeasure } from './tools/measure.js';
import { makeProfile } from './tools/profile.js';
import { makeSection } from './tools/section.js';
import { makeSight } from './tools/sight.js';
import { makeSunPath } from './tools/sun-path.js';

const kTools: readonly MakeTool[] = [
  makeMeasure,
  makeProfile,
  makeSection,
  makeSight,
  makeLayers,
  makeSunPath,
];

type Entry = {
  readonly tool: Tool;
  readonly button: HTMLButtonElement;
  readonly panel: HTMLElement;
};

export class Toolbox {
  readonly #context: ToolContext;
  readonly #entries: readonly Entry[];
  #open: Entry | undefined;

  /** @param place where the buttons and panels go */
  constructor(context: ToolContext, place: HTMLElement) {
    this.#context = context;
    this.#entries = kTools.map((make) => this.#makeEntry(make(context)));
    const buttons = element('div', { id: 'tool-buttons' });
    buttons.append(...this.#entries.map((entry) => entry.button));
    place.append(buttons, ...this.#entries.map((entry) => entry.panel));
    document.addEventListener('keydown', (event) => {
      if (event.key === 'Escape') this.#end();
    });
  }

  /** Whether clicks into the picture are for a tool. */
  get takesClicks(): boolean {
    return this.#open?.tool.click !== undefined;
  }

  click(pick: Pick): void {
    this.#open?.tool.click?.(pick);
  }

  look(look: Look): Look {
    return this.#entries.reduce((sum, { tool }) => tool.look?.(sum) ?? sum, look);
  }

  shapes(): readonly Shape[] {
    const all = this.#entries.flatMap(({ tool }) => tool.shapes());
    return all.filter((shape) => shape !== undefined);
  }

  settled(): void {
    for (const { tool } of this.#entries) tool.settled?.();
  }

  timeChanged(): void {
    for (const { tool } of this.#entries) tool.timeChanged?.();
  }

  words(): Words {
    const all = this.#entries.map(({ tool }) => tool.words());
    return Object.assign({}, ...all, { tool: this.#open?.tool.id }) as Words;
  }

  follow(words: URLSearchParams): void {
    for (const { tool } of this.#entries) tool.follow(words);
    this.#show(this.#entries.find(({ tool }) => tool.id === words.get('tool')));
  }

  #makeEntry(tool: Tool): Entry {
    const id = `tool-${tool.id}`;
    const name = this.#context.say(`tool.${tool.id}`);
    const opener = button(name, () => this.#toggle(tool));
    opener.setAttribute('aria-expanded', 'false');
    opener.setAttribute('aria-controls', id);
    const panel = element('section', { id, 'aria-label': name }, ...tool.panel);
    panel.hidden = true;
    return { tool, button: opener, panel };
  }

  #toggle(tool: Tool): void {
    const entry = this.#entries.find((candidate) => candidate.tool === tool)!;
    if (entry === this.#open) this.#show(undefined);
    else {
      this.#show(entry);
      tool.begin?.();
      entry.panel.scrollIntoView({ block: 'nearest' });
    }
    this.#context.changed();
  }

  // What the tool has made stays; focus does not get lost in a panel that is gone.
  #end(): void {
    const entry = this.#open;
    if (entry === undefined) return;
    const hadFocus = entry.panel.contains(document.activeElement);
    this.#show(undefined);
    if (hadFocus) entry.button.focus();
    this.#context.changed();
  }

  #show(entry: Entry | undefined): void {
    this.#open = entry;
    for (const each of this.#entries) {
      each.panel.hidden = each !== entry;
      each.button.setAttribute('aria-expanded', String(each === entry));
    }
  }
}
