// How much each output moves when an input moves, as bars.
import { untracked, useSignal, useSignalEffect } from "@preact/signals";
import { readable } from "./format";
import { about, answered, chosen, inputs, shown, troubleOf } from "./state";
import { ask } from "./talk";
import { Name } from "./sheet";
import type { Sensitivities } from "./types";

export function Sensitivity() {
  const found = useSignal<Sensitivities | null>(null);
  const problem = useSignal("");
  useSignalEffect(() => {
    const [document, number] = [answered.value, chosen.value];
    if (document) untracked(() => void run(document, number));
  });
  async function run(document: NonNullable<typeof answered.value>, number: number): Promise<void> {
    const reply = await ask<Sensitivities>({ do: "sensitivity", answer: number, ...about(document) });
    if (answered.value !== document) return;
    problem.value = troubleOf(reply)?.text ?? "";
    found.value = reply.outputs ? (reply as Sensitivities) : null;
  }
  const table = found.value;
  if (!table) return <p class="wrong">{problem.value}</p>;
  if (!table.outputs.length) return <p class="hint">There is no answer whose sensitivities could be shown.</p>;
  return (
    <>
      <p class="hint">How many percent larger an output becomes if an input becomes 1 % larger.</p>
      <div class="bars">
        {table.outputs.map((output, row) => (
          <Bars key={output} output={output} inputs={table.inputs} slopes={table.slopes[row]} />
        ))}
      </div>
    </>
  );
}

function Bars({ output, inputs: given, slopes }: { output: string; inputs: string[]; slopes: (number | null)[] }) {
  const value = shown.value?.values[output];
  const size = typeof value === "number" && value !== 0 ? value : null;
  const shares = given.map((name, k) => {
    const input = inputs.value[name];
    return slopes[k] === null || size === null || typeof input !== "number" ? null : (slopes[k]! * input) / size;
  });
  const most = Math.max(1e-12, ...shares.map((one) => Math.abs(one ?? 0)));
  return (
    <table class="bar" aria-label={`Sensitivities of ${output}`}>
      <caption>
        <Name name={output} />
      </caption>
      <tbody>
        {given.map((name, k) =>
          shares[k] === 0 ? null : (
            <tr key={name}>
              <th scope="row">{name}</th>
              <td class="track">
                {shares[k] !== null && (
                  <i
                    class={shares[k]! < 0 ? "less" : "more"}
                    style={{ width: `${(50 * Math.abs(shares[k]!)) / most}%`, [shares[k]! < 0 ? "right" : "left"]: "50%" }}
                  />
                )}
              </td>
              <td class="number">{shares[k] === null ? "none" : readable(shares[k], 3)}</td>
            </tr>
          ),
        )}
      </tbody>
    </table>
  );
}
