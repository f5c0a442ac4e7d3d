// The springs of the live page in WebAssembly, under Node.
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { WASI } from 'node:wasi';

export const builtKernel = join(import.meta.dirname, '../../../build/wasm/livermark.wasm');

/** @param path  of the module */
export async function startKernel(path) {
  const wasi = new WASI({ version: 'preview1' });
  const fault = (begin, length) => {
    throw new Error(new TextDecoder().decode(new Uint8Array(kernel.memory.buffer, begin, length)));
  };
  const { instance } = await WebAssembly.instantiate(await readFile(path), { ...wasi.getImportObject(), livermark: { fault } });
  const kernel = instance.exports;
  wasi.initialize(instance);
  const write = (numbers) => {
    const begin = kernel.room(numbers.length); // which may make the memory a larger one
    new Float64Array(kernel.memory.buffer, begin, numbers.length).set(numbers);
  };
  const read = (length) => {
    const begin = kernel.answer();
    return kernel.memory.buffer.slice(begin, begin + length);
  };
  return {
    open(numbers) {
      write(numbers);
      kernel.open();
    },
    /** @return bytes of the answer to a message */
    reply(numbers) {
      write(numbers);
      return read(kernel.reply());
    },
    springs: () => new TextDecoder().decode(read(kernel.spring_laws())).split(','),
  };
}
