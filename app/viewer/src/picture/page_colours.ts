// Colours that the picture takes from the page around it, which may be light or dark.

export interface PageColours {
  stage: string; // behind the body
  ink: string;
}

/** @param stage  the element around the canvas */
export function pageColours(stage: Element): PageColours {
  const { backgroundColor, color } = getComputedStyle(stage);
  return { stage: backgroundColor, ink: color };
}

/** Calls back when the page becomes light or dark. */
export function watchPageColours(onChange: () => void): void {
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', onChange);
  new MutationObserver(onChange).observe(document.documentElement, { attributes: true, attributeFilter: ['data-theme'] });
}
