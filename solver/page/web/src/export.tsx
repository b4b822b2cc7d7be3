// An exported page: sliders over states that were solved beforehand, the figures, and the values.
import { signal } from "@preact/signals";
import { render } from "preact";
import "./export.css";
import type { Value } from "./types";
import { type Data, View } from "./view";

interface Grid extends Data {
  values: ((Value | null)[] | null)[];
  drawn: ((number[] | null)[] | null)[];
}

const data = JSON.parse(document.getElementById("data")!.textContent!) as Grid;
const places = signal(data.axes.map(({ at }) => at));

function Page() {
  // the last slider runs fastest
  const row = places.value.reduce((all, at, k) => all * data.axes[k].values.length + at, 0);
  const values = data.values[row];
  const state = values && { values, drawn: data.drawn[row] ?? [] };
  const move = (axis: number, to: number) => {
    places.value = places.value.map((one, k) => (k === axis ? to : one));
  };
  return <View data={data} places={places.value} state={state} move={move} />;
}

render(<Page />, document.body);
