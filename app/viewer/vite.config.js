import { createHash } from 'node:crypto';
import { existsSync } from 'node:fs';
import { defineConfig } from 'vite';

/** Puts scripts and styles into the page, which then is one file that opens from a disk as well as from a server. */
function onePage() {
  return {
    name: 'one-page',
    enforce: 'post',
    generateBundle(_, bundle) {
      const page = bundle['index.html'];
      const take = (name) => {
        const part = bundle[name.replace(/^\.?\//, '')];
        delete bundle[part.fileName];
        return part.code ?? part.source;
      };
      // Replacements are functions, because $ in a text means something there.
      page.source = page.source
        .replace(/<link rel="stylesheet"[^>]*href="([^"]+)"[^>]*>/g, (_, name) => `<style>${take(name)}</style>`)
        .replace(/<script type="module"[^>]*src="([^"]+)"[^>]*><\/script>/g,
          (_, name) => `<script type="module">${take(name).replaceAll('</script', '<\\/script')}</script>`);
      // Scripts of the page run by what is in them, and no others: not what a result file might bring into the page.
      const scripts = [...page.source.matchAll(/<script[^>]*>([^]*?)<\/script>/g)];
      const hashes = scripts.map(([, script]) => `'sha256-${createHash('sha256').update(script).digest('base64')}'`);
      page.source = page.source.replace('<head>',
        () => `<head><meta http-equiv="Content-Security-Policy" content="script-src ${hashes.join(' ')} 'wasm-unsafe-eval'; worker-src blob: data:" />`);
      const left = Object.keys(bundle).filter((name) => name !== 'index.html');
      if (left.length > 0) this.error(`not in the page: ${left.join(', ')}`);
    },
  };
}

/** The springs in WebAssembly, where scripts/live-kernel has made them; a page without them moves springs on the server. */
const kernel = new URL('../../build/wasm/livermark.wasm', import.meta.url);

function kernelIfThere() {
  return {
    name: 'kernel-if-there',
    enforce: 'pre',
    resolveId: (source) => (source.includes('livermark.wasm') && !existsSync(kernel) ? '\0no-kernel' : null),
    load: (id) => (id === '\0no-kernel' ? "export default 'data:,'" : null),
  };
}

export default defineConfig({
  define: { HAS_KERNEL: JSON.stringify(existsSync(kernel)) },
  base: './',
  build: {
    target: 'es2022',
    modulePreload: false,
    assetsInlineLimit: Number.MAX_SAFE_INTEGER,
    chunkSizeWarningLimit: 10000, // [kB], most of it HDF5
    reportCompressedSize: false,
  },
  worker: { format: 'iife', plugins: () => [kernelIfThere()] }, // workers that are modules do not start from file://
  plugins: [kernelIfThere(), onePage()],
});
