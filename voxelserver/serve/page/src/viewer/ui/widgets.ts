/** Buttons and fields as the panel has them; each input has its name next to it. */
import { button, element, setText, toOptions } from '../../dom.js';
import type { Vec3 } from '../../vec3.js';
import type { ToolContext } from './tool.js';

/** A name and its input, in one row; more may follow. */
export function field(
  name: string,
  input: HTMLElement,
  ...after: readonly HTMLElement[]
): HTMLLabelElement {
  return element('label', {}, element('span', {}, name), input, ...after);
}

export function checkbox(
  name: string,
  isOn: boolean,
  onChange: (isOn: boolean) => void,
): { readonly row: HTMLElement; readonly input: HTMLInputElement } {
  const input = element('input', { type: 'checkbox' });
  input.checked = isOn;
  input.addEventListener('change', () => onChange(input.checked));
  return { row: element('label', { class: 'check' }, input, element('span', {}, name)), input };
}

export function numberField(
  name: string,
  range: { readonly min: number; readonly max: number; readonly step: number },
  onChange: () => void,
): { readonly row: HTMLElement; readonly input: HTMLInputElement } {
  const input = element('input', { type: 'number', ...range });
  input.addEventListener('change', onChange);
  return { row: field(name, input), input };
}

export type Slider = {
  readonly row: HTMLElement;
  value: number;
  setRange(min: number, max: number, step: number): void;
};

/** @param format of its value, which stands next to it */
export function slider(
  name: string,
  format: (value: number) => string,
  onInput: (value: number) => void,
): Slider {
  const input = element('input', { type: 'range' });
  const output = element('output');
  const show = (): void => {
    output.textContent = format(input.valueAsNumber);
    input.setAttribute('aria-valuetext', output.textContent);
  };
  input.addEventListener('input', () => {
    show();
    onInput(input.valueAsNumber);
  });
  const row = field(name, input, output);
  row.classList.add('slider');
  return {
    row,
    get value() {
      return input.valueAsNumber;
    },
    set value(value) {
      input.valueAsNumber = value;
      show();
    },
    setRange(min, max, step) {
      const before = input.valueAsNumber;
      input.min = String(min);
      input.max = String(max);
      input.step = String(step);
      input.valueAsNumber = before;
      show();
    },
  };
}

export function select<T extends string>(
  name: string,
  options: readonly (readonly [T, string])[],
  onChange: (value: T) => void,
): { readonly row: HTMLElement; readonly input: HTMLSelectElement } {
  const input = element('select', {}, ...toOptions(options));
  input.addEventListener('change', () => onChange(options[input.selectedIndex]![0]));
  return { row: field(name, input), input };
}

/** What a tool tells its user. */
export const makeNote = (): HTMLElement => element('p', { class: 'note', role: 'status' });

/** A button that takes the point in the middle of the picture; `note` says that there is none. */
export function middleButton(
  name: string,
  context: ToolContext,
  note: HTMLElement,
  use: (point: Vec3) => void,
): HTMLButtonElement {
  return button(name, () => {
    const seen = context.middle();
    if (seen === undefined) setText(note, context.say('nothingThere'));
    else use(seen.point);
  });
}
