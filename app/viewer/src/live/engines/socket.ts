// A WebSocket as questions and answers, one at a time, in order.
import { Fault } from '../../data/types.ts';

export interface Socket {
  ask(message: string | Float64Array): Promise<string | ArrayBuffer>;
  close(): void;
}

const gone = 'The server does not answer. Check that livermark view still runs, and open the file again.';

/**
 * @param file        of the server's list; the server solves for no others
 * @param onProgress  told what an answer waits for, in sentences; such messages are no answers
 */
export function openSocket(path: string, file: string, onProgress: (sentence: string) => void = () => {}): Socket {
  if (!file || !location.protocol.startsWith('http'))
    throw new Fault('The server solves for the files of its list. Start livermark view with a folder, and choose one there.');
  const socket = new WebSocket(`ws://${location.host}${path}?${new URLSearchParams({ file })}`);
  socket.binaryType = 'arraybuffer';
  const waiting: { resolve(answer: string | ArrayBuffer): void; reject(fault: Fault): void }[] = [];
  let reason = gone; // why nothing is answered any more
  const opened = new Promise<boolean>((resolve) => {
    socket.onopen = () => resolve(true);
    socket.onclose = (event) => {
      reason = event.reason || reason;
      resolve(false);
      for (const { reject } of waiting.splice(0)) reject(new Fault(reason));
    };
  });
  socket.onmessage = ({ data }: MessageEvent<string | ArrayBuffer>) => {
    const fields = new URLSearchParams(typeof data === 'string' ? data : '');
    const progress = fields.get('progress');
    if (progress !== null) return onProgress(progress);
    const fault = fields.get('fault');
    const question = waiting.shift();
    if (fault && !question) reason = fault; // the server has no room for this session
    if (fault) question?.reject(new Fault(fault));
    else question?.resolve(data);
  };
  return {
    async ask(message) {
      if (!(await opened) || socket.readyState !== WebSocket.OPEN) throw new Fault(reason);
      return new Promise((resolve, reject) => {
        waiting.push({ resolve, reject });
        socket.send(message as string | Float64Array<ArrayBuffer>);
      });
    },
    close: () => socket.close(),
  };
}
