// The state of one tab: the sheet as it is edited, its last answer, and what can be undone.
import { batch, computed, signal } from "@preact/signals";
import { readable } from "./format";
import { host } from "./host";
import { ask } from "./talk";
import type { Answer, Complaint, Frame, Geometry, Model, Motion, Rail, Reply, Value, Values } from "./types";

/** What undo restores. `inputs` override those of the sheet, null clears one; `near` tells answers apart. */
export interface Doc {
  text: string;
  inputs: Record<string, Value | null>;
  guesses: Record<string, number>;
  near: Values | null;
}

export interface View {
  tab: string;
  why: string | null;
  sweep: { name: string; start: number; stop: number; step: number } | null;
  carry: boolean;
}

/** Values on show: of an answer, of a frame of a drag, or the last ones that there were. */
export interface Shown {
  values: Values;
  figures: (Geometry | null)[];
  stale: string;
}

export interface Opened extends Model {
  sheet: string;
  name: string;
  text: string;
  seen: string;
  shipped: boolean;
  kept: { doc: Doc; view?: View } | null;
  /** Inputs with a slider in a notebook, and the values that it runs through. */
  sliders?: Slider[];
}

export interface Slider {
  name: string;
  values: Value[];
}

const EMPTY: Doc = { text: "", inputs: {}, guesses: {}, near: null };
const FIRST_VIEW: View = { tab: "rules", why: null, sweep: null, carry: false };

export const sheets = signal<{ key: string; name: string }[]>([]);
export const sheet = signal<{ key: string; name: string; seen: string; saved: string; shipped: boolean } | null>(null);
export const model = signal<Model | null>(null);
export const doc = signal<Doc>(EMPTY);
export const past = signal<Doc[]>([]);
export const future = signal<Doc[]>([]);
export const view = signal<View>(FIRST_VIEW);
export const answer = signal<Answer | null>(null);
/** The document that `answer` answers. */
export const answered = signal<Doc | null>(null);
export const trouble = signal<{ text: string; complaints: Complaint[] } | null>(null);
export const live = signal<Shown | null>(null);
/** What a drag says in place of the verdict. */
export const stroke = signal<string | null>(null);
export const motion = signal<Motion | null>(null);
export const typeset = signal<string[][] | null>(null);
export const sliders = signal<Slider[]>([]);
export const notice = signal<string>("");
export const flashed = signal<ReadonlySet<string>>(new Set());

const last = signal<Shown | null>(null);

/** The number of the answer that is nearest to the values it was chosen by. */
export const chosen = computed(() => {
  const found = answer.value;
  const near = doc.value.near;
  if (!found || !near || found.solutions.length < 2) return 0;
  const sizes = found.solutions.map((one) => apart(one, near));
  return sizes.indexOf(Math.min(...sizes));
});

export const shown = computed<Shown | null>(() => {
  if (live.value) return live.value;
  const found = answer.value;
  if (found && !trouble.value && found.solutions.length) {
    const number = Math.min(chosen.value, found.solutions.length - 1);
    return { values: found.solutions[number], figures: found.figures[number], stale: "" };
  }
  return last.value && { ...last.value, stale: last.value.stale || "last answer" };
});

/** What a value beyond the stroke means; null for one within. */
export const beyond = computed<string | null>(() => {
  if (answer.value?.status === "solved" || trouble.value) return null;
  for (const rail of Object.values(motion.value?.rails ?? {})) {
    for (const [name, [low, high]] of Object.entries(rail.limits)) {
      const value = inputs.value[name];
      if (typeof value !== "number") continue;
      if (high !== null && value > high) return strokeEnd(name, "≤", high, rail.from);
      if (low !== null && value < low) return strokeEnd(name, "≥", low, rail.from);
    }
  }
  return null;
});

export function strokeEnd(name: string, sign: string, limit: number, from: string[]): string {
  return `end of stroke: ${name} ${sign} ${readable(toShown(name, limit), 6)}${from.length ? ` (from ${from.join(", ")})` : ""}`;
}

/** The inputs in force. */
export const inputs = computed<Record<string, Value>>(() => {
  const found: Record<string, Value> = {};
  for (const { name, value } of model.value?.variables ?? []) {
    const given = name in doc.value.inputs ? doc.value.inputs[name] : value;
    if (given !== null) found[name] = given;
  }
  return found;
});

const variables = computed(() => new Map((model.value?.variables ?? []).map((one) => [one.name, one])));

export function unitOf(name: string): string {
  return variables.value.get(name)?.unit ?? "";
}

/** A value, which is in the unit of the rules, in the unit that is shown. */
export function toShown<T extends Value | null | undefined>(name: string, value: T): T {
  const [factor, shift] = variables.value.get(name)?.scale ?? [1, 0];
  if (typeof value !== "number" || (factor === 1 && shift === 0)) return value;
  return Number((value * factor + shift).toPrecision(15)) as T;
}

/** A number in the unit that is shown, in that of the rules. */
export function fromShown(name: string, value: number): number {
  const [factor, shift] = variables.value.get(name)?.scale ?? [1, 0];
  return factor === 1 && shift === 0 ? value : Number(((value - shift) / factor).toPrecision(15));
}

export const dirty = computed(() => sheet.value !== null && doc.value.text !== sheet.value.saved);

export function apart(one: Values, other: Values): number {
  let total = 0;
  for (const [name, a] of Object.entries(other)) {
    const b = one[name];
    if (typeof a === "number" && typeof b === "number") {
      total += ((a - b) / (1 + Math.max(Math.abs(a), Math.abs(b)))) ** 2;
    } else if (b !== undefined && a !== b) total += 1;
  }
  return total;
}

// --- questions about the document -------------------------------------------------

export function about(document: Doc = doc.value): { inputs: Doc["inputs"]; guesses: Doc["guesses"] } {
  return { inputs: document.inputs, guesses: document.guesses };
}

/** What a reply says when it is no answer; null for an answer. */
export function troubleOf(reply: Reply<unknown>): { text: string; complaints: Complaint[] } | null {
  if (reply.wrong) return { text: reply.wrong[0].message, complaints: reply.wrong };
  if (reply.gave_up !== undefined) {
    return { text: `no answer within ${reply.gave_up} s; the limit is --timeout`, complaints: [] };
  }
  return reply.failed ? { text: reply.failed, complaints: [] } : null;
}

let asked = 0;

export async function solve(): Promise<void> {
  const number = ++asked;
  const document = doc.value;
  const reply = await ask<Answer>({ do: "solve", ...about(document) });
  if (number !== asked || reply.superseded) return;
  const before = shown.value;
  batch(() => {
    trouble.value = troubleOf(reply);
    if (before && !live.value?.stale) last.value = before;
    if (live.value?.stale) last.value = live.value;
    live.value = null;
    stroke.value = null;
    if (!trouble.value) {
      answer.value = reply as Answer;
      answered.value = document;
    }
  });
  if (!trouble.value) await followMotion();
}

let followed = "";

/** Ask for handles and rails when anything has changed but what is dragged. */
async function followMotion(): Promise<void> {
  if (!model.value?.figures.length || !answer.value?.solutions.length) return;
  const moving = new Set((motion.value?.handles ?? []).flatMap((one) => [one.driver, one.variable]));
  const kept = (name: string) => !moving.has(name);
  const fixed = Object.entries(inputs.value).filter(([name]) => kept(name));
  const count = Object.keys(inputs.value).length;
  const key = JSON.stringify([doc.value.text, fixed, count]);
  if (motion.value?.handles.length && key === followed && onRail()) return;
  const number = asked;
  const reply = await ask<Motion>({ do: "motion", answer: chosen.value, ...about() });
  if (number !== asked || troubleOf(reply)) return;
  motion.value = { handles: reply.handles ?? [], rails: {}, extents: [] };
  for (const driver of new Set(motion.value.handles.map((one) => one.driver))) {
    const more = await ask<Followed>({ do: "rail", driver, answer: chosen.value, ...about() });
    if (number !== asked) return;
    if (more.rail && more.extents) motion.value = joined(motion.value, driver, more as Followed);
  }
  const now = new Set(motion.value.handles.flatMap((one) => [one.driver, one.variable]));
  const still = Object.entries(inputs.value).filter(([name]) => !now.has(name));
  followed = JSON.stringify([doc.value.text, still, count]);
  onMotion?.();
}

interface Followed {
  rail: Rail;
  extents: Motion["extents"];
}

/** The motion with one more rail, and with room for it. */
function joined(before: Motion, driver: string, { rail, extents }: Followed): Motion {
  const wider = extents.map((one, k) => {
    const other = before.extents[k];
    if (!one || !other) return one ?? other ?? null;
    const [a, b, c, d] = one;
    const [e, f, g, h] = other;
    return [Math.min(a, e), Math.min(b, f), Math.max(c, g), Math.max(d, h)] as [number, number, number, number];
  });
  return { ...before, rails: { ...before.rails, [driver]: rail }, extents: wider };
}

/** Called when there are new handles. */
let onMotion: (() => void) | undefined;

export function whenMoving(then: () => void): void {
  onMotion = then;
}

/** Whether the answer on show lies on the rails that are there. */
function onRail(): boolean {
  const values = shown.value?.values ?? {};
  return Object.values(motion.value?.rails ?? {}).every((rail) => rail.rows.some((row) => apart(values, row) < 0.05));
}

// --- changes ------------------------------------------------------------------------

/** Take a new document; one step of undo. */
export function commit(next: Doc, tag = ""): Promise<void> {
  if (same(next, doc.value)) return Promise.resolve();
  batch(() => {
    if (!tag || tag !== lastTag) past.value = [...past.value.slice(-199), doc.value];
    future.value = [];
    lastTag = tag;
  });
  return take(next);
}

let lastTag = "";

export function endGesture(): void {
  lastTag = "";
}

async function take(next: Doc): Promise<void> {
  const before = doc.value.text;
  doc.value = next;
  keep();
  if (next.text !== before) await reload(next.text);
  else await solve();
}

export function undo(): Promise<void> {
  return step(past, future);
}

export function redo(): Promise<void> {
  return step(future, past);
}

async function step(from: typeof past, to: typeof past): Promise<void> {
  const next = from.value.at(-1);
  if (!next) return;
  endGesture();
  notice.value = "";
  batch(() => {
    from.value = from.value.slice(0, -1);
    to.value = [...to.value, doc.value];
  });
  await take(next);
}

function same(one: Doc, other: Doc): boolean {
  const told = ({ text, inputs: given, guesses, near }: Doc) => JSON.stringify([text, given, guesses, near]);
  return told(one) === told(other);
}

export function setInput(name: string, value: Value | null, tag = ""): Promise<void> {
  const { guesses } = doc.value;
  const old = shown.value?.values[name];
  const next = { ...doc.value, inputs: { ...doc.value.inputs, [name]: value } };
  next.guesses = { ...guesses };
  delete next.guesses[name];
  if (value === null && typeof old === "number") next.guesses[name] = old;
  return commit(next, tag);
}

/** `name` becomes the input with the value it has, and `back`, if any, is solved for from where it is. */
export function swapped(name: string, back: string | null, value: Value): Doc {
  const next: Doc = { ...doc.value, inputs: { ...doc.value.inputs, [name]: value }, guesses: { ...doc.value.guesses } };
  delete next.guesses[name];
  if (back !== null) {
    const old = shown.value?.values[back];
    next.inputs[back] = null;
    if (typeof old === "number") next.guesses[back] = old;
  }
  next.near = shown.value ? { ...shown.value.values } : next.near;
  return next;
}

export function flash(names: string[], text: string): void {
  flashed.value = new Set(names);
  notice.value = text;
  setTimeout(() => (flashed.value = new Set()), 1600);
  setTimeout(() => notice.value === text && (notice.value = ""), 6000);
}

export function choose(number: number): void {
  const found = answer.value?.solutions[number];
  if (!found) return;
  doc.value = { ...doc.value, near: { ...found } };
  keep();
  void followMotion();
}

export function draw(frame: Frame, stale = ""): void {
  if (frame.values && frame.figures) live.value = { values: frame.values, figures: frame.figures, stale };
}

// --- sheets -------------------------------------------------------------------------

/** Load the text of the document; the old answer stays, dimmed, while there is something wrong with it. */
async function reload(text: string): Promise<void> {
  const reply = await ask<Model>({ do: "edit", text });
  if (doc.value.text !== text) return;
  const wrong = troubleOf(reply);
  if (wrong) {
    last.value = shown.value && { ...shown.value, stale: "" };
    trouble.value = wrong;
    return;
  }
  accept(reply as Model);
  await solve();
  void compose();
}

function accept(loaded: Model): void {
  batch(() => {
    model.value = { variables: loaded.variables, rules: loaded.rules, figures: loaded.figures };
    typeset.value = null;
    motion.value = null;
    followed = "";
  });
}

async function compose(): Promise<void> {
  const of = model.value;
  const reply = await ask<{ rules: string[][] }>({ do: "typeset" });
  if (reply.rules && model.value === of) typeset.value = reply.rules;
}

export async function openSheet(key: string, restore = true): Promise<void> {
  const reply = await ask<Opened>({ do: "open", sheet: key });
  const wrong = troubleOf(reply);
  if (reply.sheet === undefined) trouble.value = wrong;
  else await show(reply as Opened, wrong, restore ? (remembered(key) ?? undefined) : null);
}

/** Show a sheet that was opened, in the state in which it was left. */
export async function show(opened: Opened, wrong: typeof trouble.value = null, kept: Opened["kept"] = opened.kept): Promise<void> {
  const fresh = !opened.seen && !opened.shipped;
  batch(() => {
    sheet.value = {
      key: opened.sheet,
      name: opened.name,
      seen: opened.seen,
      saved: fresh ? "" : opened.text,
      shipped: opened.shipped,
    };
    answer.value = null;
    last.value = null;
    live.value = null;
    trouble.value = wrong;
    past.value = [];
    future.value = [];
    sliders.value = opened.sliders ?? [];
    view.value = { ...FIRST_VIEW, ...(fresh ? { tab: "text" } : {}), ...kept?.view };
    doc.value = { ...EMPTY, text: opened.text, ...kept?.doc };
  });
  if (!host.notebook) document.title = `${opened.name} · Backsolve`;
  if (doc.value.text !== opened.text || wrong) return reload(doc.value.text);
  accept(opened);
  await solve();
  await compose();
}

export async function save(): Promise<void> {
  const open = sheet.value;
  if (!open) return;
  const text = doc.value.text;
  const reply = await ask<{ seen: string }>({ do: "save", text, seen: open.seen });
  notice.value = troubleOf(reply)?.text ?? `saved ${open.key}`;
  if (reply.seen) sheet.value = { ...open, seen: reply.seen, saved: text };
}

// --- what a reload finds again ---------------------------------------------------------

export function setView(change: Partial<View>): void {
  view.value = { ...view.value, ...change };
  keep();
}

function keep(): void {
  const key = sheet.value?.key;
  if (!key) return;
  const state = { doc: doc.value, view: view.value };
  try {
    if (!host.notebook) {
      sessionStorage.setItem("sheet", key);
      sessionStorage.setItem(`state of ${key}`, JSON.stringify(state));
    }
  } catch {
    // a full or forbidden store: the server still keeps the state
  }
  void ask({ do: "keep", state }, true);
}

function remembered(key: string): { doc: Doc; view: View } | null {
  const text = sessionStorage.getItem(`state of ${key}`);
  return text === null ? null : JSON.parse(text);
}
