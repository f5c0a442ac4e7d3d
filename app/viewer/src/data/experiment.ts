// What the page knows of an experiment file: models beside the markers that somebody measured.
import type { Surface } from './surface.ts';

export interface Markers {
  names: string[];
  drives: string[]; // the patch that moves like this marker; empty of a marker that is compared
  position: Float64Array; // (K,3) at rest [m]
}

/** A body as it was measured. Errors are root mean square distances over the markers that are compared and were seen [m]; NaN where unknown. */
export interface ExperimentState {
  name: string;
  measured: Float64Array; // (K,3) displacement of the markers [m]; NaN of a marker that was not seen
  deformed: Float32Array; // (N,3) displacement of the body in the reference [m]
  noise: number; // of the measurement
  noMotion: number;
  rigidMotion: number;
  affineMap: number;
  straightLine: number;
  fitResidual: number; // of driving markers from the places that they drive
  referenceUncertainty: number;
}

/** A model in one state. */
export interface ExperimentRun {
  status: string;
  message: string;
  error: number; // m
  worstError: number; // m
  seconds: number;
  computed: Float64Array; // (K,3) displacement of the markers [m]
}

/** A model on one mesh. */
export interface ExperimentModel {
  name: string;
  tetrahedra: number;
  runs: (ExperimentRun | null)[]; // (S) null where it was not run
}

export interface Experiment {
  file: string;
  name: string;
  title: string;
  source: string;
  assumptions: string[];
  reference: string;
  markers: Markers;
  states: ExperimentState[];
  models: ExperimentModel[]; // the nearest to the markers first
  points: Float32Array; // (N,3) m
  surface: Surface;
  numRingDowns: number;
}
