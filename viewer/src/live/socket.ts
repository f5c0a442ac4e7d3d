// A WebSocket as questions and answers, one at a time, in order.
import { Fault } from '../data/types.ts';

export interface Socket {
  ask(message: string | Float64Array): Promise<string | ArrayBuffer>;
  close(): void;
}

const gone = 'The server does not answer. See whether livermark view still runs, and open the file again.';

/** @param file  of the server's list; the server solves for no others */
export function openSocket(path: string, file: string): Socket {
  if (!file || !location.protocol.startsWith('http'))
    throw new Fault('The server solves for the files of its list. Start livermark view with a folder, and choose one there.');
  const socket = new WebSocket(`ws://${location.host}${path}?${new URLSearchParams({ file })}`);
  socket.binaryType = 'arraybuffer';
  const waiting: { resolve(answer: string | ArrayBuffer): void; reject(fault: Fault): void }[] = [];
  const opened = new Promise<boolean>((resolve) => {
    socket.onopen = () => resolve(true);
    socket.onclose = () => {
      resolve(false);
      for (const { reject } of waiting.splice(0)) reject(new Fault(gone));
    };
  });
  socket.onmessage = ({ data }: MessageEvent<string | ArrayBuffer>) => {
    const fault = typeof data === 'string' ? new URLSearchParams(data).get('fault') : null;
    const question = waiting.shift();
    if (fault) question?.reject(new Fault(fault));
    else question?.resolve(data);
  };
  return {
    async ask(message) {
      if (!(await opened) || socket.readyState !== WebSocket.OPEN) throw new Fault(gone);
      return new Promise((resolve, reject) => {
        waiting.push({ resolve, reject });
        socket.send(message as string | Float64Array<ArrayBuffer>);
      });
    },
    close: () => socket.close(),
  };
}
