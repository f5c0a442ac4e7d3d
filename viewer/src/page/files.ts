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

/** @throws Fault if the server does not have it */
export async function fetchFile(path: string): Promise<File> {
  const address = `files/${path.split('/').map(encodeURIComponent).join('/')}`;
  const response = await fetch(address).catch(() => null);
  if (!response) throw new Fault('The server does not answer; start livermark view again.');
  if (!response.ok) throw new Fault('The server does not have it any more; load the page again for a new list.');
  return new File([await response.blob()], path);
}

export function fillList(files: Listed[], onChoose: (path: string) => void): void {
  const list = byId<HTMLSelectElement>('files');
  list.replaceChildren(...files.map(({ path }) => element('option', { value: path }, path.replace(/\.h5$/, '').replaceAll('/', ' / '))));
  list.closest('label')!.hidden = files.length === 0;
  list.addEventListener('change', () => onChoose(list.value));
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
