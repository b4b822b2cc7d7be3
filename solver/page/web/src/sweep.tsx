// A sweep over one input, as plots with a cursor.
import { untracked, useSignal, useSignalEffect } from "@preact/signals";
import { plainNumber, plural } from "./format";
import { about, doc, fromShown, inputs, model, motion, setInput, setView, shown, toShown, troubleOf, unitOf, view } from "./state";
import { ask } from "./talk";
import { Plot } from "./plot";
import type { Sweep as Swept } from "./types";

const TURNS: Record<string, number> = { deg: 360, "°": 360, rad: 6.2831853 };

/** A range to begin with: a turn of an angle, otherwise half the value to one and a half of it. */
function firstRange(name: string): [number, number, number] {
  const turn = TURNS[unitOf(name)];
  const rail = Object.values(motion.value?.rails ?? {}).find((one) => name in one.limits);
  const [low, high] = (rail?.limits[name] ?? [null, null]).map((one) => toShown(name, one));
  if (low !== null && high !== null) return [low, high, (high - low) / 60].map((one) => Number(one.toPrecision(6))) as [number, number, number];
  if (turn) return [0, turn, Number((turn / 72).toPrecision(6))];
  const value = Number(toShown(name, inputs.value[name])) || 1;
  return [value * 0.5, value * 1.5, value / 50].map((one) => Number(one.toPrecision(6))) as [number, number, number];
}

export function Sweep() {
  const numbers = Object.keys(inputs.value).filter((name) => typeof inputs.value[name] === "number");
  const found = useSignal<Swept | null>(null);
  const problem = useSignal("");
  const spec = view.value.sweep;
  const driver = (motion.value?.handles ?? []).flatMap((one) => [one.driver, one.variable]).find((one) => numbers.includes(one));
  const turning = driver ?? numbers.find((name) => TURNS[unitOf(name)]);
  const name = spec && numbers.includes(spec.name) ? spec.name : (turning ?? numbers[0]);
  const [start, stop, step] = spec?.name === name ? [spec.start, spec.stop, spec.step] : name ? firstRange(name) : [0, 1, 1];
  // The sweep depends on every input but its own.
  useSignalEffect(() => {
    const own = view.value.sweep?.name ?? name;
    const rest = Object.fromEntries(Object.entries(doc.value.inputs).filter(([one]) => one !== own));
    const key = JSON.stringify([doc.value.text, rest, view.value.sweep, own]);
    if (own && key !== asked) {
      asked = key;
      untracked(() => void run());
    }
  });
  async function run(): Promise<void> {
    const from = view.value.sweep ?? { name, start, stop, step };
    if (!from.name) return;
    const mine = asked;
    const reply = await ask<Swept>({ do: "sweep", ...from, ...about() });
    if (mine !== asked) return;
    problem.value = troubleOf(reply)?.text ?? "";
    found.value = reply.columns ? (reply as Swept) : null;
  }
  const change = (next: Partial<{ name: string; start: number; stop: number; step: number }>) => {
    const range = next.name ? firstRange(next.name) : [start, stop, step];
    setView({ sweep: { name, start: range[0], stop: range[1], step: range[2], ...next } });
  };
  const field = (label: "start" | "stop" | "step", value: number) => (
    <label>
      {label}
      <input
        value={value}
        inputMode="decimal"
        onChange={(event) => {
          const number = plainNumber(event.currentTarget.value);
          if (number !== undefined) change({ [label]: number });
        }}
      />
    </label>
  );
  const table = found.value;
  const at = table ? toShown(table.name, shown.value?.values[table.name]) : undefined;
  const cursor = typeof at === "number" ? onto(at, start, stop, TURNS[unitOf(table!.name)] ?? 0) : null;
  return (
    <div class="sweep">
      <form class="spec" onSubmit={(event) => event.preventDefault()}>
        <label>
          sweep
          <select value={name} onChange={(event) => change({ name: event.currentTarget.value })}>
            {numbers.map((one) => (
              <option key={one}>{one}</option>
            ))}
          </select>
        </label>
        {field("start", start)}
        {field("stop", stop)}
        {field("step", step)}
        {table && (
          <span class="hint">
            {table.solved} of {plural(table.rows, "row")} solved
          </span>
        )}
      </form>
      {problem.value && <p class="wrong">{problem.value}</p>}
      {table && (
        <div class="plots">
          {Object.keys(table.columns)
            .filter((one) => one !== table.name && isVariable(one) && table.columns[one].some((value) => value !== null))
            .slice(0, 24)
            .map((one) => (
              <Plot
                key={one}
                x={table.columns[table.name] as number[]}
                name={table.name}
                series={{ name: one, unit: unitOf(one), values: table.columns[one] }}
                cursor={cursor}
                here={numberOr(toShown(one, shown.value?.values[one]))}
                pick={(value) => table.name in inputs.value && void setInput(table.name, fromShown(table.name, value))}
              />
            ))}
        </div>
      )}
    </div>
  );
}

let asked = "";

function isVariable(name: string): boolean {
  return model.value?.variables.some((one) => one.name === name) ?? false;
}

function numberOr(value: unknown): number | null {
  return typeof value === "number" ? value : null;
}

/** An angle, turned into the range. */
function onto(value: number, start: number, stop: number, turn: number): number {
  if (!turn) return value;
  const low = Math.min(start, stop);
  return value - turn * Math.floor((value - low) / turn);
}
