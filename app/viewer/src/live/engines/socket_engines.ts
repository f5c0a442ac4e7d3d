// What `livermark view` solves for the page: the springs natively, and finite elements.
import { Fault } from '../../data/types.ts';
import { openSocket, type Socket } from './socket.ts';
import { springsEngine } from './springs_engine.ts';
import type { Elements, Engine, TruthEngine } from '../types.ts';

function opened(socket: Socket | null): Socket {
  if (!socket) throw new Fault('No body is open.');
  return socket;
}

/** Null where another question has interrupted the answer. */
function asFinished(answer: string | ArrayBuffer): ArrayBuffer | null {
  return typeof answer === 'string' && new URLSearchParams(answer).has('interrupted') ? null : asBytes(answer);
}

function asBytes(answer: string | ArrayBuffer): ArrayBuffer {
  if (typeof answer === 'string') throw new Fault('The server answers with something else. Load the page again.');
  return answer;
}

export function nativeEngine(): Engine {
  let socket: Socket | null = null;
  return springsEngine('native', {
    async open({ file }) {
      socket?.close();
      socket = openSocket('/live/springs', file);
      return String(await socket.ask('spring_laws'));
    },
    ask: async (message) => asBytes(await opened(socket).ask(message)),
    close: () => socket?.close(),
  });
}

/** @param onProgress  told what an answer waits for, in sentences */
export function femEngine(onProgress: (sentence: string) => void): TruthEngine {
  let socket: Socket | null = null;
  let chosen: Elements = 'linear';
  /** Both at once: what is asked meanwhile comes behind them. */
  async function askOf(elements: Elements, message: string | Float64Array): Promise<ArrayBuffer | null> {
    const others = chosen === elements ? null : opened(socket).ask(new URLSearchParams({ elements }).toString());
    chosen = elements;
    const [answer] = await Promise.all([opened(socket).ask(message), others]);
    return asFinished(answer);
  }
  return {
    async open({ file, cuts }) {
      socket?.close();
      socket = openSocket('/live/fem', file, onProgress);
      chosen = 'linear';
      if (!cuts) return;
      const { nodes, places, tetrahedra } = cuts.parted;
      const fields = new URLSearchParams({ gone: cuts.gone.join(',') });
      if (nodes.length > 0) fields.set('parted_nodes', Array.from(nodes, (node, i) => [node, ...places.subarray(3 * i, 3 * i + 3)]).join(','));
      if (tetrahedra.length > 0) fields.set('parted_tetrahedra', tetrahedra.join(','));
      await socket.ask(fields.toString());
    },
    async choose({ youngModulus, poissonRatio }) {
      await opened(socket).ask(
        new URLSearchParams({ young_modulus: String(youngModulus), poisson_ratio: String(poissonRatio) }).toString());
    },
    async solve({ disc, loadedFacets, tractions }, elements) {
      const message = new Float64Array(4 * (1 + loadedFacets.length));
      message.set([...disc.middle, disc.radius]);
      loadedFacets.forEach((facet, i) => {
        message[4 * (1 + i)] = facet;
        message.set(tractions.subarray(3 * i, 3 * i + 3), 4 * (1 + i) + 1);
      });
      const answer = await askOf(elements, message);
      const length = Float64Array.BYTES_PER_ELEMENT;
      return answer && { work: new Float64Array(answer, 0, 1)[0]!, displacement: new Float32Array(answer, length) };
    },
    async pierce({ line: { entry, target, spread }, forces }, elements) {
      const fields = { needle: [...entry, ...target, spread].join(','), forces: forces.join(',') };
      const answer = await askOf(elements, new URLSearchParams(fields).toString());
      if (!answer) return null;
      const [, x, y, z] = new Float64Array(answer, 0, 4);
      return { targetMoved: [x!, y!, z!], displacement: new Float32Array(answer, 4 * Float64Array.BYTES_PER_ELEMENT) };
    },
    interrupt() {
      chosen = 'linear';
      opened(socket).ask(new URLSearchParams({ elements: chosen }).toString()).catch(() => {}); // who asked hears of it
    },
    close: () => socket?.close(),
  };
}
