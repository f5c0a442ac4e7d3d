// An engine, of whatever carries its messages.
import { cutMessage } from '../tool/blade/blade_messages.ts';
import { bodyMessage, chooseMessage, keepMessage, moveMessage, readChosen, readCutAnswer, readFrame, resetMessage, restoreMessage } from './springs_messages.ts';
import type { Engine, LiveBody } from '../types.ts';

/** Carries messages to springs, and their answers back, in order. Faults are what `ask` throws. */
export interface Carrier {
  /** @return names of the spring laws with commas between them */
  open(body: LiveBody, message: () => Float64Array): Promise<string>;
  ask(message: Float64Array): Promise<ArrayBuffer>;
  close(): void;
}

export function springsEngine(name: string, carrier: Carrier): Engine {
  let springLaws: string[] = [];
  return {
    name,
    async open(body) {
      springLaws = (await carrier.open(body, () => bodyMessage(body))).split(',');
      return { springLaws };
    },
    choose: async (settings) => readChosen(await carrier.ask(chooseMessage(settings, springLaws))),
    move: async (tool, numSteps) => readFrame(await carrier.ask(moveMessage(tool, numSteps)), tool),
    cut: async (request) => readCutAnswer(await carrier.ask(cutMessage(request))),
    async reset() {
      await carrier.ask(resetMessage());
    },
    async keep() {
      await carrier.ask(keepMessage());
    },
    async restore() {
      await carrier.ask(restoreMessage());
    },
    close: () => carrier.close(),
  };
}
