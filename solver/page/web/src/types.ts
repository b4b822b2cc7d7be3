// What the server says; see solver/page/bench.py and server.py.
export type Value = number | string;
export type Values = Record<string, Value>;

export interface Variable {
  name: string;
  value: Value | null;
  guess: number | null;
  /** The unit shown; factor and shift lead to it from the unit of the rules, in which all values are. */
  unit: string;
  scale: [number, number];
  low: number | null;
  high: number | null;
  comment: string;
  posted: boolean;
}

export interface Rule {
  text: string;
  place: string;
  scope: string;
  names: string[];
}

export interface Outline {
  name: string;
  title: string;
  unit: string;
  polar: boolean;
  places: { name: string; kind: "point" | "pin" | "pole" }[];
  strokes: { kind: string; points: string[]; label: string }[];
}

export type Place = [number, number];

export interface Geometry {
  places: Place[];
  angles: number[];
}

export interface Model {
  variables: Variable[];
  rules: Rule[];
  figures: Outline[];
}

export interface Complaint {
  code: string;
  severity: string;
  message: string;
  notes: string[];
  variables: string[];
  places: { file: string; start: number; end: number; line: number }[];
  printed: string;
}

export interface RuleState {
  state: "used" | "idle" | "waiting" | "broken";
  step: number;
  waits: string[];
}

export interface Answer {
  status: string;
  complete: boolean;
  inputs: Values;
  undetermined: string[];
  solutions: Values[];
  partial: Values;
  figures: (Geometry | null)[][];
  diagnoses: Complaint[];
  rules: RuleState[];
}

export interface Handle {
  figure: number;
  point: string;
  driver: string;
  variable: string;
}

export interface Rail {
  closed: boolean;
  limits: Record<string, [number | null, number | null]>;
  turns: Record<string, number>;
  from: string[];
  rows: Values[];
  figures: (Geometry | null)[][];
}

export interface Motion {
  handles: Handle[];
  rails: Record<string, Rail>;
  extents: ([number, number, number, number] | null)[];
}

export interface Frame {
  status: string;
  value: number;
  values?: Values;
  figures?: (Geometry | null)[];
}

export interface Line {
  tex: string;
  unit: string;
  place?: string;
  rule?: string;
  because?: string[];
  within: boolean;
}

export interface Derivation {
  head: string;
  given: string[];
  lines: Line[];
}

export interface Sweep {
  name: string;
  columns: Record<string, (number | null)[]>;
  solved: number;
  rows: number;
}

export interface Sensitivities {
  outputs: string[];
  inputs: string[];
  slopes: (number | null)[][];
}

/** Every reply may instead say that something is wrong, or that it was given up. */
export interface Trouble {
  wrong?: Complaint[];
  failed?: string;
  gave_up?: number;
  superseded?: boolean;
}

export type Reply<T> = Partial<T> & Trouble;
