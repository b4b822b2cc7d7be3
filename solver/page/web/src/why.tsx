// Why a number is what it is.
import { untracked, useSignal, useSignalEffect } from "@preact/signals";
import { about, answered, model, setView, troubleOf, view } from "./state";
import { ask } from "./talk";
import { Formula } from "./math";
import type { Derivation } from "./types";

export function Why() {
  const found = useSignal<Derivation | null>(null);
  const problem = useSignal("");
  useSignalEffect(() => {
    const name = view.value.why;
    const document = answered.value;
    if (name && document) untracked(() => void run(name, document));
  });
  async function run(name: string, document: NonNullable<typeof answered.value>): Promise<void> {
    const reply = await ask<Derivation>({ do: "why", name, ...about(document) });
    if (view.value.why !== name) return;
    problem.value = troubleOf(reply)?.text ?? "";
    found.value = reply.head ? (reply as Derivation) : null;
  }
  const names = model.value?.variables.map((one) => one.name) ?? [];
  return (
    <div class="why">
      <form class="spec" onSubmit={(event) => event.preventDefault()}>
        <label>
          why
          <select value={view.value.why ?? ""} onChange={(event) => setView({ why: event.currentTarget.value })}>
            <option value="" disabled>
              choose a variable
            </option>
            {names.map((one) => (
              <option key={one}>{one}</option>
            ))}
          </select>
        </label>
        <span class="hint">{view.value.why ? (found.value?.head ?? "") : "or click a number of the sheet"}</span>
      </form>
      {problem.value && <p class="wrong">{problem.value}</p>}
      {found.value && view.value.why && (
        <>
          {found.value.given.length > 0 && <p class="given">given {found.value.given.join(" · ")}</p>}
          <ol class="lines">
            {found.value.lines.map((line, number) => (
              <li key={number} class={line.within ? "within" : ""}>
                <Formula tex={line.tex} text={line.tex} />
                {line.unit}
                <small>
                  {line.place && <span class="place">{line.place}</span>} <code>{line.rule}</code>{" "}
                  {line.because?.map((one) => <em key={one}>{one}</em>)}
                </small>
              </li>
            ))}
          </ol>
        </>
      )}
    </div>
  );
}
