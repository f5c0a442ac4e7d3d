// Making pieces of the page. Texts of files go in as text, never as markup.

/** @throws Error if index.html lacks it, which is a mistake of ours */
export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`no element #${id}`);
  return element as T;
}

type Attributes = Record<string, string | number>;
type Child = Node | string;

export function element<K extends keyof HTMLElementTagNameMap>(name: K, attributes: Attributes = {}, ...content: Child[]): HTMLElementTagNameMap[K] {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
  made.append(...content);
  return made;
}

export function svg(name: string, attributes: Attributes = {}, ...content: Child[]): SVGElement {
  const made = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, String(value));
  made.append(...content);
  return made;
}

export function row(cell: 'td' | 'th', ...cells: Child[]): HTMLTableRowElement {
  return element('tr', {}, ...cells.map((content) => element(cell, cell === 'th' ? { scope: 'col' } : {}, content)));
}

/** A name that may go on in the next line behind each underscore. */
export function breakable(name: string): HTMLElement {
  const parts = name.split(/(?<=_)/);
  return element('span', {}, ...parts.flatMap((part, i) => (i === 0 ? [part] : [element('wbr'), part])));
}

/** Replaces what is in a part of the page. Who was at an element with a data-key is at the new one of that key then. */
export function refill(parent: HTMLElement, content: Node[]): void {
  const focused = document.activeElement;
  const key = (focused instanceof HTMLElement || focused instanceof SVGElement) && parent.contains(focused) ? focused.dataset['key'] : undefined;
  parent.replaceChildren(...content);
  if (key) parent.querySelector<HTMLElement>(`[data-key="${CSS.escape(key)}"]`)?.focus({ preventScroll: true });
}

/** Scrolls what is around a part of the page, and not the page, until the part is seen. */
export function showInside(part: HTMLElement): void {
  const around = part.parentElement!;
  const hidden = part.offsetTop + Math.min(part.offsetHeight, around.clientHeight) - around.scrollTop - around.clientHeight;
  if (hidden > 0) around.scrollTop += hidden;
}
