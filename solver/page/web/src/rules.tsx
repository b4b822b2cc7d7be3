// The rules, typeset, each with its state and its place in the path; messages stand at their rules.
import { answer, answered, doc, model, trouble, typeset } from "./state";
import { Formula } from "./math";
import { Message } from "./messages";
import type { Complaint, Rule, RuleState } from "./types";

const WORDS = { used: "used", idle: "idle", waiting: "waits", broken: "broken" };

export function Rules() {
  const rules = model.value?.rules ?? [];
  const states = answered.value?.text === doc.value.text ? (answer.value?.rules ?? []) : [];
  return (
    <ol class="rules" aria-label="Rules">
      {rules.map((rule, number) => (
        <Item key={number} rule={rule} state={states[number]} lines={typeset.value?.[number]} />
      ))}
    </ol>
  );
}

function Item({ rule, state, lines }: { rule: Rule; state?: RuleState; lines?: string[] }) {
  const word = state?.state ?? "idle";
  const found = trouble.value ? [] : (answer.value?.diagnoses ?? []).filter((one) => first(one) === rule.place);
  return (
    <li class={word} title={rule.text}>
      <span class="state">
        <i aria-hidden="true" />
        {WORDS[word]}
      </span>
      <span class="step">{state?.step || ""}</span>
      <span class="says">
        {(lines ?? [""]).map((tex, k) => (
          <span key={k}>{tex ? <Formula tex={tex} text={rule.text} /> : <code>{rule.text}</code>}</span>
        ))}
        {state?.waits.length ? <small>waits for {state.waits.join(", ")}</small> : null}
      </span>
      <span class="place">{rule.place}</span>
      {found.map((one) => (
        <Message key={one.code + one.message} complaint={one} />
      ))}
    </li>
  );
}

function first(complaint: Complaint): string {
  const place = complaint.places[0];
  return place ? `${place.file.split("/").at(-1)}:${place.line}` : "";
}
