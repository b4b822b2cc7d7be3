// The variable sheet: status, name, value, unit, comment. Click a status to turn an input into an output.
import { useComputed, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { plainNumber, readable, typed } from "./format";
import {
  about,
  answer,
  choose,
  chosen,
  commit,
  doc,
  flash,
  flashed,
  inputs,
  live,
  model,
  setInput,
  setView,
  shown,
  stroke,
  swapped,
  toShown,
  trouble,
  troubleOf,
} from "./state";
import { ask } from "./talk";
import { dragging } from "./drag";
import { host } from "./host";
import type { Value, Variable } from "./types";

export function Sheet() {
  const rows = model.value?.variables.filter((one) => one.posted) ?? [];
  const all = rows.length ? rows : (model.value?.variables ?? []);
  return (
    <section class="sheet" aria-label="Variable sheet">
      <Answers />
      <table role="grid" aria-label="Variables" onKeyDown={walk}>
        <thead>
          <tr>
            <th scope="col">St</th>
            <th scope="col">Name</th>
            <th scope="col" class="number">
              Value
            </th>
            <th scope="col">Unit</th>
            <th scope="col">Comment</th>
          </tr>
        </thead>
        <tbody>
          {all.map((variable) => (
            <Row key={variable.name} variable={variable} />
          ))}
        </tbody>
      </table>
    </section>
  );
}

function Answers() {
  const count = answer.value?.solutions.length ?? 0;
  if (count < 2 || trouble.value) return null;
  const move = (event: KeyboardEvent) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (step) choose((chosen.value + step + count) % count);
  };
  return (
    <div class="answers" role="tablist" aria-label="Answers" onKeyDown={move}>
      {answer.value!.solutions.slice(0, 24).map((_, number) => (
        <button
          key={number}
          role="tab"
          tabIndex={number === chosen.value ? 0 : -1}
          aria-selected={number === chosen.value}
          onClick={() => choose(number)}
        >
          Answer {number + 1}
        </button>
      ))}
      {!answer.value!.complete && <span class="hint">perhaps not all</span>}
    </div>
  );
}

function Row({ variable }: { variable: Variable }) {
  const { name } = variable;
  const given = name in inputs.value;
  const marked = flashed.value.has(name) || dragging.value?.variable === name;
  const blamed =
    (stroke.value !== null && dragging.value?.variable === name) ||
    (answer.value?.diagnoses ?? []).some((one) => one.variables.includes(name));
  return (
    <tr class={`${given ? "given" : "found"} ${marked ? "marked" : ""} ${blamed ? "blamed" : ""}`} data-name={name}>
      <td class="status">
        <Status variable={variable} given={given} />
      </td>
      <th scope="row" class="name">
        <Name name={name} />
      </th>
      <td class="number">{given ? <Field variable={variable} /> : <Output variable={variable} />}</td>
      <td class="unit">{variable.unit}</td>
      <td class="comment">
        {variable.comment}
        <Range variable={variable} />
        {!given && <Guess variable={variable} />}
      </td>
    </tr>
  );
}

export function Name({ name }: { name: string }) {
  const [head, ...rest] = name.split(".");
  return rest.length ? (
    <span>
      <span class="scope">{head}.</span>
      {rest.join(".")}
    </span>
  ) : (
    <span>{name}</span>
  );
}

/** An input: a number, an expression of numbers, or a symbol. Enter commits, Esc restores. */
function Field({ variable }: { variable: Variable }) {
  const { name, unit } = variable;
  const field = useRef<HTMLInputElement>(null);
  const wrong = useSignal("");
  const dragged = live.value?.values[name];
  const value = dragging.value?.variable === name && dragged !== undefined ? dragged : inputs.value[name];
  const text = typed(toShown(name, value));
  useEffect(() => {
    if (field.current && host.root.activeElement !== field.current) field.current.value = text;
  }, [text]);
  const enter = async () => {
    const now = field.current!.value.trim();
    wrong.value = "";
    if (now === text) return;
    if (now === "") return void setInput(name, null);
    const number = variable.scale[0] === 1 && variable.scale[1] === 0 ? plainNumber(now) : undefined;
    const reply = number === undefined ? await ask<{ value: Value }>({ do: "value", name, text: now }) : { value: number };
    const found = troubleOf(reply);
    if (found || reply.value === undefined) {
      wrong.value = [found?.text ?? "not a value", ...(found?.complaints[0]?.notes ?? []).slice(0, 1)].join("; ");
    }
    else await setInput(name, reply.value);
    if (!wrong.value && field.current) field.current.value = typed(toShown(name, inputs.value[name]));
  };
  return (
    <>
      <input
        ref={field}
        defaultValue={text}
        aria-label={`${name}${unit && `, in ${unit}`}`}
        aria-invalid={wrong.value !== ""}
        title={wrong.value || undefined}
        inputMode="decimal"
        autocomplete="off"
        spellcheck={false}
        onBlur={enter}
        onKeyDown={(event) => {
          if (event.key === "Enter") void enter();
          if (event.key === "Escape") {
            event.currentTarget.value = text;
            wrong.value = "";
          }
        }}
      />
      {wrong.value && (
        <small class="wrong" role="alert">
          {wrong.value}
        </small>
      )}
    </>
  );
}

/** Where the values of a variable may lie, as the sheet says. */
function Range({ variable }: { variable: Variable }) {
  const [low, high] = [variable.low, variable.high].map((end) => toShown(variable.name, end));
  if (low === null && high === null) return null;
  const said = high === null ? `≥ ${readable(low)}` : low === null ? `≤ ${readable(high)}` : `${readable(low)} to ${readable(high)}`;
  return <small class="range">{said}</small>;
}

/** A first guess, where there is one or where the variable has no value. Of several answers the nearest comes first. */
function Guess({ variable }: { variable: Variable }) {
  const { name } = variable;
  const guess = doc.value.guesses[name] ?? variable.guess;
  const wrong = useSignal(false);
  if (guess === null && shown.value?.values[name] !== undefined) return null;
  const text = typed(toShown(name, guess));
  const enter = async (field: HTMLInputElement) => {
    const now = field.value.trim();
    wrong.value = false;
    if (now === text) return;
    const guesses = { ...doc.value.guesses };
    delete guesses[name];
    if (now !== "") {
      const { value } = await ask<{ value: Value }>({ do: "value", name, text: now });
      wrong.value = typeof value !== "number";
      if (typeof value !== "number") return;
      guesses[name] = value;
    }
    // the answer that is nearest to the new guess comes in front
    await commit({ ...doc.value, guesses, near: null });
  };
  return (
    <label class="guess">
      guess
      <input
        key={text}
        defaultValue={text}
        aria-label={`guess for ${name}`}
        aria-invalid={wrong.value}
        inputMode="decimal"
        autocomplete="off"
        onBlur={(event) => void enter(event.currentTarget)}
        onKeyDown={(event) => {
          if (event.key === "Enter") void enter(event.currentTarget);
          if (event.key === "Escape") event.currentTarget.value = text;
        }}
      />
    </label>
  );
}

/** A number that was found; a click says why. */
function Output({ variable }: { variable: Variable }) {
  const { name } = variable;
  const text = useComputed(() => readable(toShown(name, shown.value?.values[name])));
  const stale = useComputed(() => (shown.value?.stale || shown.value?.values[name] === undefined ? "value stale" : "value"));
  return (
    <button
      class={stale}
      role="gridcell"
      aria-readonly="true"
      title={`Why ${name}?`}
      onClick={() => setView({ why: name, tab: "why" })}
    >
      {text}
    </button>
  );
}

/** The status cell, TK's gesture: an output keeps its value and becomes an input, and the other way round. */
function Status({ variable, given }: { variable: Variable; given: boolean }) {
  const { name } = variable;
  const choices = useSignal<string[] | null>(null);
  const value = shown.value?.values[name];
  const press = async () => {
    if (given) return void setInput(name, null);
    if (value === undefined) return void edit(name);
    const reply = await ask<{ choices: string[] }>({ do: "swap", name, answer: chosen.value, ...about() });
    if (reply.choices?.length) choices.value = reply.choices;
    else void commit(swapped(name, null, value));
  };
  const accept = (back: string | null) => {
    choices.value = null;
    void commit(swapped(name, back, value!));
    flash(back === null ? [name] : [name, back], back === null ? "" : `${name} is an input now; ${back} is solved for`);
  };
  const [word, other] = given ? ["input", "output"] : ["output", "input"];
  return (
    <>
      <button class="st" aria-label={`${name}, ${word}; press to make it an ${other}`} title={`Make ${name} an ${other}`} onClick={press}>
        {given ? "I" : value === undefined ? "·" : "O"}
      </button>
      {choices.value && <Menu name={name} choices={choices.value} accept={accept} cancel={() => (choices.value = null)} />}
    </>
  );
}

function edit(name: string): void {
  const guess = doc.value.guesses[name];
  void setInput(name, guess ?? 1).then(() => {
    host.root.querySelector<HTMLInputElement>(`tr[data-name="${CSS.escape(name)}"] input`)?.select();
  });
}

interface MenuProps {
  name: string;
  choices: string[];
  accept: (back: string | null) => void;
  cancel: () => void;
}

/** Which input to take back. */
function Menu({ name, choices, accept, cancel }: MenuProps) {
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => box.current?.querySelector("button")?.focus(), []);
  const keys = (event: KeyboardEvent) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    event.stopPropagation();
    if (event.key === "Escape") cancel();
    if (!step) return;
    event.preventDefault();
    const all = [...box.current!.querySelectorAll("button")];
    all[(all.indexOf(host.root.activeElement as HTMLButtonElement) + step + all.length) % all.length].focus();
  };
  const leave = (event: FocusEvent) => {
    if (!box.current?.contains(event.relatedTarget as Node)) cancel();
  };
  return (
    <div ref={box} class="menu" role="menu" aria-label={`Make ${name} an input`} onKeyDown={keys} onFocusOut={leave}>
      <p>Make {name} an input and</p>
      {choices.map((back) => (
        <button key={back} role="menuitem" onClick={() => accept(back)}>
          take back {back}
        </button>
      ))}
      <button role="menuitem" onClick={() => accept(null)}>
        keep all inputs
      </button>
    </div>
  );
}

/** Arrows walk through the grid, Home and End along a row, with Ctrl to the first and the last row. */
function walk(event: KeyboardEvent): void {
  const here = event.target as HTMLElement;
  const cell = here.closest("td");
  if (!cell) return;
  const field = here instanceof HTMLInputElement ? here : null;
  const rows = [...here.closest("tbody")!.rows];
  const row = rows.indexOf(cell.parentElement as HTMLTableRowElement);
  const column = cell.cellIndex;
  const start = !field || (field.selectionStart === 0 && field.selectionEnd === (field.selectionEnd === 0 ? 0 : field.value.length));
  const go = (to: number, at: number) => {
    const next = rows[to]?.cells[at]?.querySelector<HTMLElement>("input, button");
    if (!next) return;
    event.preventDefault();
    next.focus();
    if (next instanceof HTMLInputElement) next.select();
  };
  if (event.key === "ArrowDown") go(row + 1, column);
  if (event.key === "ArrowUp") go(row - 1, column);
  if (event.key === "ArrowLeft" && start) go(row, 0);
  if (event.key === "ArrowRight" && !field) go(row, 2);
  if (event.key === "Home" && event.ctrlKey) go(0, column);
  if (event.key === "End" && event.ctrlKey) go(rows.length - 1, column);
}
