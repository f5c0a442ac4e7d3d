// Light or dark: as the system says, until the reader says otherwise.
import { byId } from './elements.ts';

const key = 'livermark-theme';
const prefersDark = matchMedia('(prefers-color-scheme: dark)');

/** A page from a disk may have no memory. */
function remembered(): string | null {
  try {
    return localStorage.getItem(key);
  } catch {
    return null;
  }
}

function remember(theme: string): void {
  try {
    localStorage.setItem(key, theme);
  } catch {
    // Then it is for this time only.
  }
}

export function listenToTheme(): void {
  const root = document.documentElement;
  const button = byId('theme');
  const isDark = () => (root.dataset['theme'] ?? (prefersDark.matches ? 'dark' : 'light')) === 'dark';
  const show = () => button.setAttribute('aria-pressed', String(isDark()));
  const chosen = remembered();
  if (chosen === 'dark' || chosen === 'light') root.dataset['theme'] = chosen;
  button.addEventListener('click', () => {
    const next = isDark() ? 'light' : 'dark';
    root.dataset['theme'] = next;
    remember(next);
    show();
  });
  prefersDark.addEventListener('change', show);
  show();
}
