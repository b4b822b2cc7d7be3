// A figure of the sheet as SVG, in its own units; points that can be dragged are sliders.
import { signal, useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { cancel, dragging, grab, limitsOf, move, nudge, railOf, release } from "./drag";
import { niceStep, readable } from "./format";
import { answer, chosen, endGesture, motion, shown, toShown, trouble, unitOf } from "./state";
import type { Geometry, Handle, Outline, Place } from "./types";
import { Drawing, type Box, boxOf } from "./drawing";

const boxes = signal<Record<string, Box>>({});

/** The part of the plane on show: the whole motion where it is known; it never shrinks in a drag. */
function useBox(outline: Outline, index: number): Box | null {
  useSignalEffect(() => {
    const all: (Geometry | null | undefined)[] = (answer.value?.figures ?? []).map((one) => one[index]);
    const extent = motion.value?.extents?.[index];
    const found = boxOf(all, extent ?? null, outline.polar);
    if (found && !dragging.value) boxes.value = { ...boxes.peek(), [outline.name]: found };
  });
  return boxes.value[outline.name] ?? null;
}

export function Figure({ outline, index }: { outline: Outline; index: number }) {
  const svg = useRef<SVGSVGElement>(null);
  const size = useSignal<Place>([480, 320]);
  useEffect(() => {
    const watch = new ResizeObserver(([entry]) => {
      size.value = [entry.contentRect.width, entry.contentRect.height];
    });
    watch.observe(svg.current!);
    return () => watch.disconnect();
  }, []);
  const box = useBox(outline, index);
  const now = shown.value;
  const geometry = now?.figures[index] ?? null;
  const [width, height] = size.value;
  const unit = box ? Math.max(box.width / Math.max(width - 90, 50), box.height / Math.max(height - 64, 50)) : 1;
  const ghosts = dragging.value || trouble.value ? [] : (answer.value?.solutions ?? []).map((_, number) => number);
  const view = box
    ? [box.x - (width * unit) / 2, -box.y - (height * unit) / 2, width * unit, height * unit]
    : [0, 0, 1, 1];
  return (
    <figure class={`figure ${outline.polar ? "polar" : "main"}`}>
      <svg ref={svg} viewBox={view.join(" ")} data-figure={outline.name} role="group" aria-label={`${outline.title}`}>
        {box && (
          <g transform="scale(1,-1)">
            {ghosts
              .filter((number) => number !== chosen.value)
              .map((number) => {
                const other = answer.value!.figures[number][index];
                return other && <Drawing key={number} outline={outline} geometry={other} unit={unit} ghost />;
              })}
            {geometry && <Drawing outline={outline} geometry={geometry} unit={unit} stale={!!now?.stale} />}
            {geometry && <Handles outline={outline} index={index} geometry={geometry} unit={unit} svg={svg} />}
          </g>
        )}
      </svg>
      <figcaption>
        <span>{outline.title}</span>
        {box && <ScaleBar unit={unit} name={outline.unit} />}
        {now?.stale && !outline.polar && <em class="stale-label">{now.stale}</em>}
      </figcaption>
    </figure>
  );
}

function ScaleBar({ unit, name }: { unit: number; name: string }) {
  const length = niceStep(90 * unit);
  return (
    <span class="scale">
      <i style={{ width: `${length / unit}px` }} />
      {readable(length, 3)}
      {name && ` ${name}`}
    </span>
  );
}

interface HandlesProps {
  outline: Outline;
  index: number;
  geometry: Geometry;
  unit: number;
  svg: { current: SVGSVGElement | null };
}

function Handles({ outline, index, geometry, unit, svg }: HandlesProps) {
  const here = (motion.value?.handles ?? []).filter((one) => one.figure === index && railOf(one));
  return (
    <>
      {here.map((handle) => {
        const place = geometry.places[outline.places.findIndex((one) => one.name === handle.point)];
        return <Knob key={handle.point} handle={handle} place={place} unit={unit} svg={svg} />;
      })}
    </>
  );
}

function Knob({ handle, place, unit, svg }: { handle: Handle; place: Place; unit: number; svg: HandlesProps["svg"] }) {
  const [low, high] = limitsOf(handle);
  const value = shown.value!.values[handle.variable] as number;
  const pointer = (event: PointerEvent): Place => {
    const matrix = (svg.current!.firstElementChild as SVGGElement).getScreenCTM()!;
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
    return [at.x, at.y];
  };
  return (
    <g
      class={`knob ${dragging.value?.point === handle.point ? "held" : ""}`}
      data-handle={handle.point}
      transform={`translate(${place[0]},${place[1]})`}
      tabIndex={0}
      role="slider"
      aria-label={`${handle.point}: drag to move ${handle.variable}`}
      aria-valuemin={toShown(handle.variable, low)}
      aria-valuemax={toShown(handle.variable, high)}
      aria-valuenow={toShown(handle.variable, value)}
      aria-valuetext={`${handle.variable} ${readable(toShown(handle.variable, value), 6)} ${unitOf(handle.variable)}`}
      onPointerDown={(event) => {
        if (event.button !== 0 || !grab(handle, unit)) return;
        event.currentTarget.setPointerCapture(event.pointerId);
        event.currentTarget.focus();
        event.preventDefault();
      }}
      onPointerMove={(event) => {
        if (event.currentTarget.hasPointerCapture(event.pointerId)) move(pointer(event));
      }}
      onPointerUp={release}
      onPointerCancel={cancel}
      onKeyDown={(event) => {
        if (event.key === "Escape") cancel();
        else if (nudge(handle, event)) event.preventDefault();
      }}
      onBlur={endGesture}
    >
      <circle class="target" r={22 * unit} />
      <circle class="ring" r={9 * unit} />
      <circle class="dot" r={4 * unit} />
    </g>
  );
}
