// The curve that a handle is dragged along, cut into legs on which its variable does not turn back.
import type { Handle, Place, Rail, Values } from "./types";

export interface Leg {
  /** The handle's variable, unwrapped, and the place of its point, row by row. */
  v: number[];
  places: Place[];
  rows: Values[];
  /** The last row leads on to the first. */
  round: boolean;
  /** Whether the variable has a limit at the start and at the end, where another leg goes on. */
  limited: [boolean, boolean];
}

export interface Spot {
  value: number;
  near: Values;
  /** How far the pointer is beyond a limit, in the variable; 0 on the leg. */
  beyond: number;
  /** The end of the leg that it is at: 0, 1, or -1 for neither. */
  end: number;
}

export function legsOf(rail: Rail, handle: Handle, index: number): Leg[] {
  const turn = rail.turns[handle.variable] ?? 0;
  const rows = rail.closed ? [...rail.rows, rail.rows[0]] : [...rail.rows];
  const figures = rail.closed ? [...rail.figures, rail.figures[0]] : [...rail.figures];
  const v = unwrapped(rows.map((row) => row[handle.variable] as number), turn);
  const places = figures.map((one) => one[handle.figure]!.places[index]);
  const winds = rail.closed && turn > 0 && Math.abs(v[v.length - 1] - v[0]) > turn / 2;
  if (winds) return [{ v, places, rows, round: true, limited: [false, false] }];
  const [lows, cut] = [v.indexOf(Math.min(...v)), v.length - 1];
  const order = rail.closed ? range(0, cut).map((k) => (k + lows) % cut).concat(lows) : range(0, v.length);
  const pick = (from: number, to: number): Leg => {
    const some = order.slice(from, to + 1);
    return {
      v: some.map((k) => v[k]),
      places: some.map((k) => places[k]),
      rows: some.map((k) => rows[k]),
      round: false,
      limited: [rail.closed || from > 0, rail.closed || to < order.length - 1],
    };
  };
  const turns = range(1, order.length - 1).filter((k) => {
    const [before, here, after] = [order[k - 1], order[k], order[k + 1]].map((n) => v[n]);
    return (here - before) * (after - here) < 0;
  });
  const ends = [0, ...turns, order.length - 1];
  return ends.slice(1).map((to, k) => pick(ends[k], to));
}

/** The leg that values lie on. */
export function legAt(legs: Leg[], variable: string, values: Values): number {
  const misses = legs.map((leg) => miss(leg, variable, values));
  return misses.indexOf(Math.min(...misses));
}

function miss(leg: Leg, variable: string, values: Values): number {
  const spot = onLeg(leg, values[variable] as number, variable);
  let total = 0;
  for (const [name, a] of Object.entries(spot.near)) {
    const b = values[name];
    if (typeof a === "number" && typeof b === "number") {
      const turnless = name === variable ? 0 : Math.abs(a - b);
      total += (Math.min(turnless, Math.abs(turnless - 360)) / (1 + Math.abs(a))) ** 2;
    }
  }
  return total;
}

/** The place on a leg where the variable has a value, or the end that is nearest to it. */
export function onLeg(leg: Leg, value: number, variable: string): Spot {
  const { v } = leg;
  let at = value;
  if (leg.round) {
    const turn = v[v.length - 1] - v[0];
    at = value - turn * Math.floor((value - v[0]) / turn);
  }
  const rising = v[v.length - 1] >= v[0];
  const [low, high] = rising ? [v[0], v[v.length - 1]] : [v[v.length - 1], v[0]];
  const inside = Math.min(Math.max(at, low), high);
  let k = v.findIndex((here, n) => n + 1 < v.length && (here - inside) * (v[n + 1] - inside) <= 0);
  if (k < 0) k = 0;
  const step = v[k + 1] - v[k];
  return spotAt(leg, k, step ? (inside - v[k]) / step : 0, variable, inside);
}

function spotAt(leg: Leg, k: number, share: number, variable: string, value: number): Spot {
  const near: Values = {};
  for (const [name, a] of Object.entries(leg.rows[k])) {
    const b = leg.rows[k + 1][name];
    if (typeof a !== "number" || typeof b !== "number") continue;
    let step = b - a;
    if (Math.abs(step) > 180) step -= 360 * Math.round(step / 360);
    near[name] = a + share * step;
  }
  near[variable] = value;
  const end = leg.round ? -1 : k === 0 && share <= 0 ? 0 : k === leg.v.length - 2 && share >= 1 ? 1 : -1;
  return { value, near, beyond: 0, end };
}

/** The place on a leg that is nearest to the pointer, and how far the pointer is beyond its ends. */
export function project(leg: Leg, pointer: Place, variable: string): Spot {
  let best = Infinity;
  let [row, share] = [0, 0];
  for (let k = 0; k + 1 < leg.places.length; k++) {
    const [a, b] = [leg.places[k], leg.places[k + 1]];
    const along: Place = [b[0] - a[0], b[1] - a[1]];
    const size = along[0] ** 2 + along[1] ** 2;
    const raw = size ? ((pointer[0] - a[0]) * along[0] + (pointer[1] - a[1]) * along[1]) / size : 0;
    const s = Math.min(Math.max(raw, 0), 1);
    const gap = Math.hypot(pointer[0] - a[0] - s * along[0], pointer[1] - a[1] - s * along[1]);
    if (gap < best) [best, row, share] = [gap, k, s];
  }
  const value = leg.v[row] + share * (leg.v[row + 1] - leg.v[row]);
  const spot = spotAt(leg, row, share, variable, value);
  if (spot.end >= 0) spot.beyond = overshoot(leg, spot.end, pointer);
  return spot;
}

/** How far beyond an end of the leg the pointer is along the way in which the point gets there. */
function overshoot(leg: Leg, end: number, pointer: Place): number {
  const last = leg.v.length - 1;
  const [at, from] = end ? [last, Math.max(0, last - 3)] : [0, Math.min(last, 3)];
  const dv = leg.v[at] - leg.v[from];
  const way: Place = [leg.places[at][0] - leg.places[from][0], leg.places[at][1] - leg.places[from][1]];
  const size = way[0] ** 2 + way[1] ** 2;
  if (!size) return 0;
  const off = [pointer[0] - leg.places[at][0], pointer[1] - leg.places[at][1]];
  const share = (off[0] * way[0] + off[1] * way[1]) / size;
  return share > 0 ? share * dv : 0;
}

function unwrapped(values: number[], turn: number): number[] {
  let shift = 0;
  return values.map((value, k) => {
    if (turn && k) shift -= turn * Math.round((value - values[k - 1]) / turn);
    return value + shift;
  });
}

function range(from: number, to: number): number[] {
  return Array.from({ length: Math.max(0, to - from) }, (_, k) => from + k);
}

/** An angle between minus and plus half a turn. */
export function wrapped(value: number, turn: number): number {
  if (!turn) return value;
  const low = value - turn * Math.ceil(value / turn - 0.5);
  return low + 0;
}
