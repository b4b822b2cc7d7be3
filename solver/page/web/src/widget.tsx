// The cell of a notebook: the same view, each state solved by the kernel as a slider moves.
import { signal } from "@preact/signals";
import { render } from "preact";
import css from "./export.css";
import { type Data, type State, View } from "./view";

/** What anywidget hands over. */
interface Kernel {
  get(name: "data"): Data & { state: State | null };
  send(message: { places: number[] }): void;
  on(event: "msg:custom", heard: (message: { state: State | null }) => void): void;
  off(event: "msg:custom", heard: (message: { state: State | null }) => void): void;
}

function show({ model, el }: { model: Kernel; el: HTMLElement }) {
  const data = model.get("data");
  const places = signal(data.axes.map(({ at }) => at));
  const state = signal(data.state);
  let [asked, waiting] = [false, false];
  // one question at a time; when it is answered, the latest one that waits
  const ask = () => {
    waiting = asked;
    if (!asked) model.send({ places: places.value });
    asked = true;
  };
  const heard = (message: { state: State | null }) => {
    asked = false;
    state.value = message.state;
    if (waiting) ask();
  };
  const move = (axis: number, to: number) => {
    places.value = places.value.map((one, k) => (k === axis ? to : one));
    ask();
  };
  model.on("msg:custom", heard);
  const root = el.attachShadow({ mode: "open" });
  const style = document.createElement("style");
  style.textContent = css;
  const body = document.createElement("div");
  body.className = "sheet";
  root.append(style, body);
  const Cell = () => <View data={data} places={places.value} state={state.value} move={move} />;
  render(<Cell />, body);
  return () => {
    model.off("msg:custom", heard);
    render(null, body);
  };
}

export default { render: show };
