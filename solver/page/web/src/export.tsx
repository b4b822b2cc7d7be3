// An exported page: sliders over states that were solved beforehand, the figures, and the values.
import { signal } from "@preact/signals";
import { render } from "preact";
import "./export.css";
import { boxOf, Drawing, type Extent } from "./drawing";
import { niceStep, readable } from "./format";
import type { Geometry, Outline, Place, Value } from "./types";

interface Data {
  name: string;
  axes: { name: string; values: Value[]; at: number }[];
  variables: { name: string; unit: string; comment: string }[];
  given: string[];
  values: ((Value | null)[] | null)[];
  figures: Outline[];
  boxes: (Extent | null)[];
  drawn: ((number[] | null)[] | null)[];
}

const data = JSON.parse(document.getElementById("data")!.textContent!) as Data;
const places = signal(data.axes.map(({ at }) => at));

/** The state at the sliders; the last one runs fastest. */
function state(): number {
  return places.value.reduce((row, at, k) => row * data.axes[k].values.length + at, 0);
}

function Page() {
  const row = state();
  const values = data.values[row];
  return (
    <main>
      <h1>{data.name}</h1>
      <section class="sliders">
        {data.axes.map((axis, k) => (
          <Slider key={axis.name} number={k} />
        ))}
      </section>
      {!values && <p class="none">There is no answer here.</p>}
      <section class="figures">
        {data.figures.map((outline, k) => (
          <Figure key={outline.name} outline={outline} box={data.boxes[k]} flat={data.drawn[row]?.[k] ?? null} />
        ))}
      </section>
      <table>
        <tbody>
          {data.variables.map(({ name, unit, comment }, k) => (
            <tr key={name} class={data.given.includes(name) ? "given" : ""}>
              <th scope="row">{name}</th>
              <td class="number">{values ? readable(values[k], 6) : ""}</td>
              <td>{unit}</td>
              <td>{comment}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <footer>Solved beforehand by Backsolve; every state shown was checked against every rule.</footer>
    </main>
  );
}

function Slider({ number }: { number: number }) {
  const { name, values } = data.axes[number];
  const at = places.value[number];
  const about = data.variables.find((one) => one.name === name);
  return (
    <label>
      <span>
        <b>{name}</b> {about?.comment}
      </span>
      <input
        type="range"
        min={0}
        max={values.length - 1}
        value={at}
        aria-valuetext={`${name} ${readable(values[at], 6)} ${about?.unit ?? ""}`}
        onInput={(event) => {
          const next = Number(event.currentTarget.value);
          places.value = places.value.map((one, k) => (k === number ? next : one));
        }}
      />
      <output>
        {readable(values[at], 6)} {about?.unit}
      </output>
    </label>
  );
}

function Figure({ outline, box, flat }: { outline: Outline; box: Extent | null; flat: number[] | null }) {
  const [width, height] = outline.polar ? [340, 230] : [700, 340];
  const around = boxOf([], box, outline.polar);
  if (!around) return null;
  const unit = Math.max(around.width / (width - 90), around.height / (height - 70));
  const view = [around.x - (width * unit) / 2, -around.y - (height * unit) / 2, width * unit, height * unit];
  const length = niceStep(80 * unit);
  return (
    <figure class={outline.polar ? "polar" : "main"}>
      <svg viewBox={view.join(" ")} role="img" aria-label={outline.title}>
        <g transform="scale(1,-1)">{flat && <Drawing outline={outline} geometry={unflat(outline, flat)} unit={unit} />}</g>
      </svg>
      <figcaption>
        {outline.title} · {readable(length, 3)} {outline.unit}
        <svg class="scale" viewBox={`0 0 ${length / unit} 6`} style={{ width: `${(100 * length) / unit / width}%` }}>
          <path d={`M0.5,0V5H${length / unit - 0.5}V0`} />
        </svg>
      </figcaption>
    </figure>
  );
}

function unflat(outline: Outline, flat: number[]): Geometry {
  const count = outline.places.length;
  return {
    places: outline.places.map((_, k): Place => [flat[2 * k], flat[2 * k + 1]]),
    angles: flat.slice(2 * count),
  };
}

render(<Page />, document.body);
