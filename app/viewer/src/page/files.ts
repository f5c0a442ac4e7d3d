// Where files come from: the list of the server, the button, or dropped on the page.
import { Fault } from '../data/types.ts';
import { byId, element } from './elements.ts';

interface Listed {
  path: string;
  bytes: number;
}

/** Nothing where no `livermark view` answers: the page then is a file, or somebody else serves it. */
export async function listedFiles(): Promise<Listed[]> {
  if (!location.protocol.startsWith('http')) return [];
  try {
    const response = await fetch('files.json');
    return response.ok ? ((await response.json()) as Listed[]) : [];
  } catch {
    return [];
  }
}

/**
 * @param signal      breaks it off
 * @param onProgress  the part that has arrived, 0 to 1
 * @throws Fault if the server does not have it
 */
export async function fetchFile(path: string, signal: AbortSignal, onProgress: (part: number) => void): Promise<File> {
  const address = `files/${path.split('/').map(encodeURIComponent).join('/')}`;
  const response = await fetch(address, { signal }).catch(() => null);
  if (!response) throw new Fault('The server does not answer; start livermark view again.');
  if (!response.ok) throw new Fault('The server does not have it any more; load the page again for a new list.');
  const numBytes = Number(response.headers.get('content-length'));
  const parts: Uint8Array<ArrayBuffer>[] = [];
  let numArrived = 0;
  const reader = response.body!.getReader();
  try {
    for (let next = await reader.read(); !next.done; next = await reader.read()) {
      parts.push(next.value);
      numArrived += next.value.length;
      if (numBytes > 0) onProgress(Math.min(numArrived / numBytes, 1));
    }
  } catch {
    throw new Fault('The server stopped in the middle of it; start livermark view again.');
  }
  return new File(parts, path);
}

const bodyOf = (path: string) => path.split('/').at(-2) ?? '';

/** Bodies by their names, and the beam, which is there to check models, behind them. */
export const inOrder = (files: Listed[]): Listed[] =>
  [...files].sort((a, b) => Number(bodyOf(a.path) === 'beam') - Number(bodyOf(b.path) === 'beam'));

/** What a reader sees who has asked for nothing: a liver, with lesions if there is one, that a finger presses, deep if there is that. */
export function firstOf(files: Listed[]): Listed | undefined {
  const wanted = [/^large_palpation\.h5$/, /^palpation\.h5$/, /^large_.*\.h5$/];
  const rank = ({ path }: Listed) => {
    const body = bodyOf(path), place = wanted.findIndex((name) => name.test(path.split('/').at(-1)!));
    return 10 * (body === 'liver_tumours' ? 0 : body.startsWith('liver') ? 1 : body === 'beam' ? 3 : 2) + (place < 0 ? wanted.length : place);
  };
  return files.reduce<Listed | undefined>((best, file) => (!best || rank(file) < rank(best) ? file : best), undefined);
}

export function fillList(files: Listed[], onChoose: (path: string) => void): void {
  const list = byId<HTMLSelectElement>('files');
  list.replaceChildren(...files.map(({ path }) => element('option', { value: path }, path.replace(/\.h5$/, '').replaceAll('/', ' / '))));
  list.closest('label')!.hidden = files.length === 0;
  list.addEventListener('change', () => onChoose(list.value));
}

/** @param path  of the file that is shown; empty for one that is not in the list */
export function showListed(path: string): void {
  const list = byId<HTMLSelectElement>('files');
  list.value = path;
  if (list.value !== path || path === '') list.selectedIndex = -1;
}

export function acceptFiles(onFile: (file: File) => void): void {
  const input = byId<HTMLInputElement>('chosen');
  byId('choose').addEventListener('click', () => input.click());
  input.addEventListener('change', () => {
    const file = input.files?.[0];
    if (file) onFile(file);
    input.value = ''; // so that the same file can be chosen again
  });
  const hint = byId('drop');
  window.addEventListener('dragover', (event) => {
    event.preventDefault();
    hint.hidden = false;
  });
  window.addEventListener('dragleave', (event) => {
    if (!event.relatedTarget) hint.hidden = true;
  });
  window.addEventListener('drop', (event) => {
    event.preventDefault();
    hint.hidden = true;
    const file = event.dataTransfer?.files[0];
    if (file) onFile(file);
  });
}
