// Diagnoses, as the terminal prints them; a sentence that names a value is a button that applies it.
import { plainNumber } from "./format";
import { inputs, setInput } from "./state";
import type { Complaint } from "./types";

export function Message({ complaint, open = false }: { complaint: Complaint; open?: boolean }) {
  return (
    <article class={`message ${complaint.severity}`}>
      <p>
        <strong>{complaint.code}</strong> {complaint.message}
      </p>
      {complaint.notes.map((note) => (
        <Note key={note} note={note} />
      ))}
      {complaint.places.length > 0 && (
        <details open={open}>
          <summary>where</summary>
          <pre>{complaint.printed}</pre>
        </details>
      )}
    </article>
  );
}

function Note({ note }: { note: string }) {
  const offers = offered(note);
  return (
    <p class="note">
      {note}
      {offers.map(({ name, value }) => (
        <button key={name} onClick={() => void setInput(name, value)}>
          {value === null ? `leave out ${name}` : `set ${name} = ${value}`}
        </button>
      ))}
    </p>
  );
}

/** What a note proposes: `leave out f: …`, `xB ≤ 10.8167`. Bounds are met with a little to spare. */
function offered(note: string): { name: string; value: number | null }[] {
  const out = /^leave out ([^:\s]+):/.exec(note);
  if (out) return out[1] in inputs.value ? [{ name: out[1], value: null }] : [];
  return [...note.matchAll(/([\p{L}_][\p{L}\p{N}_.#]*) ([≤≥]) ([-+\d.e]+\d)/gu)].flatMap(([, name, sign, digits]) => {
    const bound = plainNumber(digits);
    if (bound === undefined || typeof inputs.value[name] !== "number") return [];
    const inside = bound + (sign === "≤" ? -1 : 1) * Math.max(Math.abs(bound), 1e-300) * 1e-4;
    return [{ name, value: Number(inside.toPrecision(5)) }];
  });
}
