// Sliders, the figures and the values of a sheet: what an exported page shows.
import { boxOf, Drawing, type Extent } from "./drawing";
import { niceStep, readable } from "./format";
import type { Geometry, Outline, Place, Value } from "./types";

export interface Data {
  name: string;
  axes: { name: string; values: Value[]; at: number }[];
  variables: { name: string; unit: string; comment: string }[];
  given: string[];
  figures: Outline[];
  boxes: (Extent | null)[];
  said: string;
}

/** One state: a value for each variable, and the coordinates and angles of each figure. */
export interface State {
  values: (Value | null)[];
  drawn: (number[] | null)[];
}

interface Props {
  data: Data;
  places: number[];
  state: State | null;
  move: (axis: number, place: number) => void;
}

export function View({ data, places, state, move }: Props) {
  return (
    <main>
      <h1>{data.name}</h1>
      <section class="sliders">
        {data.axes.map((axis, k) => (
          <Slider key={axis.name} data={data} number={k} at={places[k]} move={move} />
        ))}
      </section>
      {!state && <p class="none">There is no answer here.</p>}
      <section class="figures">
        {data.figures.map((outline, k) => (
          <Figure key={outline.name} outline={outline} box={data.boxes[k]} flat={state?.drawn[k] ?? null} />
        ))}
      </section>
      <table>
        <tbody>
          {data.variables.map(({ name, unit, comment }, k) => (
            <tr key={name} class={data.given.includes(name) ? "given" : ""}>
              <th scope="row">{name}</th>
              <td class="number">{state ? readable(state.values[k], 6) : ""}</td>
              <td>{unit}</td>
              <td>{comment}</td>
            </tr>
          ))}
        </tbody>
      </table>
      <footer>{data.said}</footer>
    </main>
  );
}

function Slider({ data, number, at, move }: { data: Data; number: number; at: number; move: Props["move"] }) {
  const { name, values } = data.axes[number];
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
        onInput={(event) => move(number, Number(event.currentTarget.value))}
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
