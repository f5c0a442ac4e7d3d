// The springs in WebAssembly: gives the module what it imports, and calls it. See app/live/wasm/exports.cpp.
import { Fault } from '../../data/types.ts';

interface Exports {
  memory: WebAssembly.Memory;
  __stack_pointer: WebAssembly.Global<'i32'>;
  _initialize(): void;
  room(numNumbers: number): number;
  answer(): number;
  open(): void;
  reply(): number;
  spring_laws(): number;
}

export interface Kernel {
  springLaws(): string;
  open(message: Float64Array): void;
  reply(message: Float64Array): ArrayBuffer;
}

const done = 0; // of what C libraries ask of a system
const notThere = 8; // EBADF: there are no files

/** @throws Fault from its functions, with a sentence for the reader of the page; the kernel can then go on */
export async function startKernel(module: WebAssembly.Module): Promise<Kernel> {
  const view = () => new DataView(kernel.memory.buffer);
  const system = {
    environ_get: () => done,
    environ_sizes_get(numVariables: number, numBytes: number) {
      view().setUint32(numVariables, 0, true);
      view().setUint32(numBytes, 0, true);
      return done;
    },
    clock_time_get(_clock: number, _precision: bigint, nanoseconds: number) {
      view().setBigUint64(nanoseconds, BigInt(Math.round(performance.now() * 1e6)), true);
      return done;
    },
    fd_close: () => notThere,
    fd_seek: () => notThere,
    fd_write: () => notThere,
    proc_exit(status: number) {
      throw new Error(`the springs ended with status ${status}`);
    },
  };
  const fault = (begin: number, length: number) => {
    throw new Fault(new TextDecoder().decode(new Uint8Array(kernel.memory.buffer, begin, length)));
  };
  const instance = await WebAssembly.instantiate(module, { wasi_snapshot_preview1: system, livermark: { fault } });
  const kernel = instance.exports as unknown as Exports;
  kernel._initialize();
  const stack: number = kernel.__stack_pointer.value;

  const write = (message: Float64Array) => {
    const begin = kernel.room(message.length);
    new Float64Array(kernel.memory.buffer, begin, message.length).set(message);
  };
  const read = (length: number): ArrayBuffer => {
    const begin = kernel.answer();
    return kernel.memory.buffer.slice(begin, begin + length) as ArrayBuffer;
  };
  // A fault leaves the functions of the kernel without their ends, which would have given the stack back.
  const guarded = <T>(call: () => T): T => {
    try {
      return call();
    } finally {
      kernel.__stack_pointer.value = stack;
    }
  };
  return {
    springLaws: () => guarded(() => new TextDecoder().decode(read(kernel.spring_laws()))),
    open: (message) =>
      guarded(() => {
        write(message);
        kernel.open();
      }),
    reply: (message) =>
      guarded(() => {
        write(message);
        return read(kernel.reply());
      }),
  };
}
