// What the page asks of the worker that reads a file, and what it answers. A worker reads one file only, which it is asked to open first.
import type { Experiment } from './experiment.ts';
import type { Field, ForcePlot, Largest, Moment, NodeValues, PointErrors, ProbeMotion, Result, SoftBody } from './types.ts';

/** What a file is about: solutions of models, or models beside an experiment. */
export type Content = { result: Result } | { experiment: Experiment };

export interface Questions {
  open: { question: { file: File }; answer: Content };
  field: { question: { model: string; moment: Moment; strain: boolean }; answer: Field };
  largest: { question: { model: string; moving: boolean; strain: boolean }; answer: Largest };
  node: { question: { node: number; moment: Moment }; answer: NodeValues[] };
  motion: { question: { probe: number; reference: string }; answer: ProbeMotion[] };
  errors: { question: { point: number }; answer: PointErrors[] };
  forces: { question: null; answer: ForcePlot[] };
  body: { question: null; answer: SoftBody };
}
export type Kind = keyof Questions;

export interface Message<K extends Kind = Kind> {
  id: number;
  kind: K;
  question: Questions[K]['question'];
}

export type Reply = { id: number } & ({ answer: unknown } | { fault: string });
