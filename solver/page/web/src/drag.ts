// One drag, from the grab to the release: one step of undo, one question in flight, the latest value wins.
import { type Leg, legAt, legsOf, onLeg, project, type Spot, wrapped } from "./rail";
import { niceStep, readable, rounded } from "./format";
import { about, commit, doc, draw, flash, inputs, live, model, motion, shown, stroke, strokeEnd, swapped, toShown, view } from "./state";
import type { Doc } from "./state";
import { ask } from "./talk";
import type { Frame, Handle, Place, Rail, Values } from "./types";
import { signal } from "@preact/signals";

export const dragging = signal<Handle | null>(null);

interface Wanted {
  value: number;
  near: Values;
  stale: string;
}

/** Frames for one input: one question in flight, the latest value wins. */
export class Frames {
  private next: Wanted | null = null;
  private flying = false;
  private stopped = false;

  constructor(
    private readonly name: string,
    private readonly work: Doc,
  ) {}

  want(next: Wanted): void {
    this.next = next;
    if (!this.flying) void this.pump();
  }

  stop(): void {
    this.stopped = true;
  }

  private async pump(): Promise<void> {
    this.flying = true;
    while (this.next && !this.stopped) {
      const { value, near, stale } = this.next;
      this.next = null;
      const frame = await ask<Frame>({ do: "frame", name: this.name, value, near, ...about(this.work) }, true);
      if (this.stopped) break;
      if (frame.values) draw(frame as Frame, stale);
      else if (!stale && shown.value) live.value = { ...shown.value, stale: `no answer at ${this.name} = ${readable(toShown(this.name, value), 6)}` };
    }
    this.flying = false;
  }
}

/** A drag that is under way. */
class Drag {
  private readonly before = doc.value;
  private readonly legs: Leg[];
  private leg: number;
  private work: Doc;
  private moved = false;
  private readonly frames: Frames;
  private value: number;
  private over = false;

  constructor(
    readonly handle: Handle,
    readonly rail: Rail,
    private readonly step: number,
  ) {
    const outline = model.value!.figures[handle.figure];
    const index = outline.places.findIndex((place) => place.name === handle.point);
    this.legs = legsOf(rail, handle, index);
    const { values } = shown.value!;
    this.value = values[handle.variable] as number;
    this.leg = legAt(this.legs, handle.variable, values);
    this.work = takeOver(handle, this.value);
    this.frames = new Frames(handle.variable, this.work);
  }

  /** The pointer is there. */
  move(pointer: Place): void {
    if (!this.moved) {
      this.moved = true;
      doc.value = this.work;
      dragging.value = this.handle;
    }
    const { variable } = this.handle;
    let spot = project(this.legs[this.leg], pointer, variable);
    if (view.value.carry && spot.end >= 0 && this.legs[this.leg].limited[spot.end]) {
      this.leg = (this.leg + (spot.end ? 1 : this.legs.length - 1)) % this.legs.length;
      spot = project(this.legs[this.leg], pointer, variable);
    }
    this.show(spot);
  }

  private show(spot: Spot): void {
    const { variable } = this.handle;
    const turn = this.rail.turns[variable] ?? 0;
    const leg = this.legs[this.leg];
    const limit = spot.end >= 0 && leg.limited[spot.end] ? leg.v[spot.end ? leg.v.length - 1 : 0] : null;
    const past = limit !== null && Math.abs(spot.beyond) > this.step;
    this.over = past;
    this.value = wrapped(rounded(past ? limit + spot.beyond : spot.value, this.step), turn);
    if (past) {
      stroke.value = strokeEnd(variable, spot.beyond > 0 ? "≤" : "≥", limit, this.rail.from);
    } else stroke.value = null;
    const inside = past ? within(leg, spot.end) : onLeg(leg, this.value, variable).value;
    const near = onLeg(leg, inside, variable).near;
    const stale = past ? `last answer at ${variable} = ${readable(toShown(variable, wrapped(inside, turn)), 6)}` : "";
    this.frames.want({ value: past ? wrapped(inside, turn) : this.value, near, stale });
  }

  /** The pointer is released: what is on show is the new document. */
  async release(): Promise<void> {
    const near = live.value?.values ?? this.before.near;
    this.end();
    if (!this.moved) return;
    const { variable } = this.handle;
    if (!this.over) stroke.value = null;
    await commit({ ...this.work, inputs: { ...this.work.inputs, [variable]: this.value }, near: near && { ...near } });
  }

  cancel(): void {
    this.end();
    live.value = null;
    stroke.value = null;
  }

  private end(): void {
    current = null;
    this.frames.stop();
    dragging.value = null;
    doc.value = this.before;
  }
}

let current: Drag | null = null;

/** A little inside a limit, where an answer can still be told from its twin. */
function within(leg: Leg, end: number): number {
  const [at, other] = end ? [leg.v[leg.v.length - 1], leg.v[0]] : [leg.v[0], leg.v[leg.v.length - 1]];
  return at - 1e-5 * (at - other);
}

/** The document in which a handle's variable is the input. */
function takeOver(handle: Handle, value: number): Doc {
  if (handle.variable in inputs.value) return { ...doc.value, near: { ...shown.value!.values } };
  const driver = driverOf(handle);
  flash([handle.variable, driver], `${handle.variable} is the input now; ${driver} is solved for`);
  return swapped(handle.variable, driver, value);
}

/** The input that moves a handle now: one of those that its motion shares. */
function driverOf(handle: Handle): string {
  const all = motion.value!.handles.filter((one) => one.driver === handle.driver);
  const names = [handle.driver, ...all.map((one) => one.variable)];
  return names.find((name) => name in inputs.value) ?? handle.driver;
}

export function railOf(handle: Handle): Rail | undefined {
  return motion.value?.rails[handle.driver];
}

export function grab(handle: Handle, unitsPerPixel: number): boolean {
  const rail = railOf(handle);
  if (!rail || current || !shown.value || shown.value.stale === "last answer") return false;
  current = new Drag(handle, rail, pixelStep(handle, rail, unitsPerPixel));
  return true;
}

/** The change of the variable that a pixel stands for, rounded down to a power of ten. */
function pixelStep(handle: Handle, rail: Rail, unitsPerPixel: number): number {
  const turn = rail.turns[handle.variable] ?? 0;
  return turn ? turn / 3600 : 10 ** Math.floor(Math.log10(unitsPerPixel));
}

/** Have plans ready before a handle is touched. */
export function warm(): void {
  for (const handle of motion.value?.handles ?? []) {
    const rail = railOf(handle);
    if (!rail) continue;
    const { variable } = handle;
    const every = Math.ceil(rail.rows.length / 12);
    const values = rail.rows.filter((_, k) => k % every === 1).map((row) => row[variable] as number);
    const given: Doc["inputs"] = { ...doc.value.inputs, [variable]: values[0] };
    const driver = driverOf(handle);
    if (driver !== variable) given[driver] = null;
    void ask({ do: "warm", name: variable, values, inputs: given });
  }
}

export function move(pointer: Place): void {
  current?.move(pointer);
}

export function release(): void {
  void current?.release();
}

export function cancel(): void {
  current?.cancel();
}

/** The least and the greatest value of a handle's variable. */
export function limitsOf(handle: Handle): [number, number] {
  const rail = railOf(handle);
  const turn = rail?.turns[handle.variable] ?? 0;
  const values = (rail?.rows ?? []).map((row) => row[handle.variable] as number);
  const [low, high] = rail?.limits[handle.variable] ?? [null, null];
  if (turn && low === null) return [-turn / 2, turn / 2];
  return [low ?? Math.min(...values), high ?? Math.max(...values)];
}

/** Move a handle by keys: arrows one nice step, Shift ten, Alt a tenth, Home and End to its limits. */
export function nudge(handle: Handle, event: KeyboardEvent): boolean {
  const rail = railOf(handle);
  const sign = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
  if (!rail || !shown.value || (sign === undefined && event.key !== "Home" && event.key !== "End")) return false;
  const turn = rail.turns[handle.variable] ?? 0;
  const [low, high] = limitsOf(handle);
  const size = niceStep((high - low) / 200) * (event.shiftKey ? 10 : event.altKey ? 0.1 : 1);
  const inset = 1e-6 * (high - low);
  const now = shown.value.values[handle.variable] as number;
  const aim = sign === undefined ? (event.key === "Home" ? low : high) : rounded(now + sign * size, size);
  const winds = turn > 0 && high - low >= turn;
  const value = winds ? wrapped(aim, turn) : Math.min(Math.max(aim, low + inset), high - inset);
  const work = takeOver(handle, value);
  void commit({ ...work, inputs: { ...work.inputs, [handle.variable]: value } }, `key ${handle.variable}`);
  return true;
}
