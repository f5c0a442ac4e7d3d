// What `livermark view` solves for the page: the springs natively, and finite elements.
import { Fault } from '../../data/types.ts';
import { openSocket, type Socket } from './socket.ts';
import { springsEngine } from './springs_engine.ts';
import type { Elements, Engine, TruthEngine } from '../types.ts';

function opened(socket: Socket | null): Socket {
  if (!socket) throw new Fault('No body is open.');
  return socket;
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
      if (chosen !== elements) await opened(socket).ask(new URLSearchParams({ elements }).toString());
      chosen = elements;
      const message = new Float64Array(4 * (1 + loadedFacets.length));
      message.set([...disc.middle, disc.radius]);
      loadedFacets.forEach((facet, i) => {
        message[4 * (1 + i)] = facet;
        message.set(tractions.subarray(3 * i, 3 * i + 3), 4 * (1 + i) + 1);
      });
      const answer = asBytes(await opened(socket).ask(message));
      const length = Float64Array.BYTES_PER_ELEMENT;
      return { work: new Float64Array(answer, 0, 1)[0]!, displacement: new Float32Array(answer, length) };
    },
    async pierce({ line: { entry, target, spread }, forces }) {
      const fields = { needle: [...entry, ...target, spread].join(','), forces: forces.join(',') };
      const answer = asBytes(await opened(socket).ask(new URLSearchParams(fields).toString()));
      const [, x, y, z] = new Float64Array(answer, 0, 4);
      return { targetMoved: [x!, y!, z!], displacement: new Float32Array(answer, 4 * Float64Array.BYTES_PER_ELEMENT) };
    },
    close: () => socket?.close(),
  };
}
