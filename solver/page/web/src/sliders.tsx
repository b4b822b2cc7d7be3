// Sliders of a notebook's cell: each runs through the values that it was given.
import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { Frames } from "./drag";
import { readable } from "./format";
import { commit, doc, inputs, live, shown, type Slider as Given, sliders, toShown, unitOf } from "./state";
import type { Value } from "./types";

export function Sliders() {
  const here = sliders.value.filter(({ name }) => name in inputs.value);
  if (!here.length) return null;
  return (
    <div class="sliders">
      {here.map((one) => (
        <Slider key={one.name} {...one} />
      ))}
    </div>
  );
}

function Slider({ name, values }: Given) {
  const frames = useRef<Frames | null>(null);
  const aim = useSignal<number | null>(null);
  const at = aim.value ?? nearest(values, live.value?.values[name] ?? inputs.value[name]);
  const text = `${readable(toShown(name, values[at]), 6)} ${unitOf(name)}`;
  const move = (place: number) => {
    aim.value = place;
    const value = values[place];
    if (typeof value === "string") return;
    frames.current ??= new Frames(name, doc.value);
    frames.current.want({ value, near: shown.value?.values ?? {}, stale: "" });
  };
  const release = async (place: number) => {
    frames.current?.stop();
    frames.current = null;
    const near = typeof values[place] === "number" && shown.value ? { ...shown.value.values } : doc.value.near;
    await commit({ ...doc.value, inputs: { ...doc.value.inputs, [name]: values[place] }, near });
    aim.value = null;
    live.value = null;
  };
  return (
    <label>
      <b>{name}</b>
      <input
        type="range"
        min={0}
        max={values.length - 1}
        value={at}
        aria-valuetext={`${name} ${text}`}
        onInput={(event) => move(Number(event.currentTarget.value))}
        onChange={(event) => void release(Number(event.currentTarget.value))}
      />
      <output>{text}</output>
    </label>
  );
}

/** The position of a value, or of the number that is nearest to it. */
function nearest(values: Value[], value: Value): number {
  const gaps = values.map((one) => (one === value ? 0 : typeof one === "number" && typeof value === "number" ? Math.abs(one - value) : Infinity));
  return gaps.indexOf(Math.min(...gaps));
}
