// Links, joints and arrows of a figure; also what an exported page draws.
import type { Geometry, Outline, Place } from "./types";

export interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

export type Extent = [number, number, number, number];

/** The box around every place of the geometries and the extent of the whole motion. */
export function boxOf(geometries: (Geometry | null | undefined)[], extent: Extent | null, polar: boolean): Box | null {
  const places = geometries.flatMap((one) => one?.places ?? []);
  if (extent) places.push([extent[0], extent[1]], [extent[2], extent[3]]);
  if (!places.length) return null;
  const xs = places.map((place) => place[0]);
  const ys = places.map((place) => place[1]);
  const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const least = Math.max(right - left, high - low, polar ? 0 : 1e-9) || 1;
  return {
    x: (left + right) / 2,
    y: (low + high) / 2,
    width: Math.max(right - left, 0.05 * least),
    height: Math.max(high - low, 0.05 * least),
  };
}

interface Props {
  outline: Outline;
  geometry: Geometry;
  /** Units of the figure a pixel. */
  unit: number;
  ghost?: boolean;
  stale?: boolean;
}

export function Drawing({ outline, geometry, unit, ghost, stale }: Props) {
  const places = new Map(outline.places.map((place, k) => [place.name, geometry.places[k]]));
  const name = ghost ? "ghost" : stale ? "stale" : "";
  return (
    <g class={`drawing ${name}`} aria-hidden="true">
      {outline.strokes.map((stroke, k) => {
        const points = stroke.points.map((point) => places.get(point)!);
        return <Stroke key={k} kind={stroke.kind} points={points} angle={geometry.angles[k]} unit={unit} ends={stroke.points} />;
      })}
      {outline.places.map(({ name: point, kind }) => (
        <Joint key={point} kind={kind} place={places.get(point)!} unit={unit} />
      ))}
      {!ghost && <Labels outline={outline} places={places} unit={unit} />}
    </g>
  );
}

interface StrokeProps {
  kind: string;
  points: Place[];
  angle: number;
  unit: number;
  ends: string[];
}

function Stroke({ kind, points, angle, unit, ends }: StrokeProps) {
  const [a, b] = points;
  if (kind === "slider" || kind === "block" || kind === "trunnion") {
    return (
      <g class={kind} transform={`translate(${a[0]},${a[1]}) rotate(${angle}) scale(${unit})`}>
        {kind === "slider" && <path class="ground" d="M-34,-10H34" />}
        <rect x={-15} y={-9} width={30} height={18} rx={2} />
      </g>
    );
  }
  if (kind === "body") return <polygon class="body" points={points.map((p) => p.join(",")).join(" ")} />;
  if (kind === "line" || kind === "slot") {
    return (
      <>
        {points.slice(1).map((to, k) => (
          <line
            key={k}
            class={kind}
            data-ends={`${ends[k]},${ends[k + 1]}`}
            x1={points[k][0]}
            y1={points[k][1]}
            x2={to[0]}
            y2={to[1]}
          />
        ))}
      </>
    );
  }
  const length = Math.hypot(b[0] - a[0], b[1] - a[1]);
  const turn = (Math.atan2(b[1] - a[1], b[0] - a[0]) * 180) / Math.PI;
  const head = Math.min(9, length / unit / 2);
  return (
    <g class={`arrow ${kind}`}>
      <line x1={a[0]} y1={a[1]} x2={b[0]} y2={b[1]} />
      {head > 1 && (
        <path
          transform={`translate(${b[0]},${b[1]}) rotate(${turn}) scale(${unit})`}
          d={`M0,0L${-head},${head * 0.38}V${-head * 0.38}Z`}
        />
      )}
    </g>
  );
}

function Joint({ kind, place, unit }: { kind: string; place: Place; unit: number }) {
  return (
    <g class={`joint ${kind}`} transform={`translate(${place[0]},${place[1]}) scale(${unit})`}>
      {kind === "pin" && <path class="ground" d="M0,0L-9,-15H9Z M-14,-15H14 M-10,-15l-5,-5 M-3,-15l-5,-5 M4,-15l-5,-5 M11,-15l-5,-5" />}
      <circle r={kind === "pole" ? 2.5 : 3.5} />
    </g>
  );
}

const JOINTS = new Set(["slider", "block", "trunnion"]);

/** Names of points beside them, away from the strokes that meet there; of arrows beside their middle. */
function Labels({ outline, places, unit }: { outline: Outline; places: Map<string, Place>; unit: number }) {
  const texts: Label[] = [];
  const taken: Place[] = [];
  for (const { name, kind: joint } of outline.places) {
    const at = places.get(name)!;
    if (name.startsWith("_")) continue;
    const same = taken.findIndex((other) => Math.hypot(other[0] - at[0], other[1] - at[1]) < 3 * unit);
    if (same >= 0) {
      texts[same].text += `, ${name}`;
      continue;
    }
    taken.push(at);
    const jointed = outline.strokes.some(({ kind, points }) => JOINTS.has(kind) && points[0] === name);
    const [x, y] = away(at, name, outline, places);
    texts.push({ text: name, at, off: joint === "pin" ? [x > 0 ? 1 : -1, 0.6] : jointed ? [0.35 * Math.sign(x), 1.35] : [1.15 * x, 1.15 * y] });
  }
  for (const stroke of outline.strokes) {
    const [a, b] = stroke.points.map((point) => places.get(point)!);
    if (!stroke.label || !b || Math.hypot(b[0] - a[0], b[1] - a[1]) < 34 * unit) continue;
    const size = Math.hypot(b[0] - a[0], b[1] - a[1]);
    const side: Place = [(a[1] - b[1]) / size, (b[0] - a[0]) / size];
    texts.push({ text: stroke.label, at: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], off: [side[0] * 0.8, side[1] * 0.8] });
  }
  return (
    <>
      {apart(texts, unit).map(({ text, at, off }, k) => (
        <text key={k} transform={`translate(${at[0] + 16 * unit * off[0]},${at[1] + 16 * unit * off[1]}) scale(${unit},${-unit})`}>
          {text}
        </text>
      ))}
    </>
  );
}

interface Label {
  text: string;
  at: Place;
  off: Place;
}

/** Labels that do not cover one another: one in the way goes to the other side, or is left out. */
function apart(labels: Label[], unit: number): Label[] {
  const kept: Label[] = [];
  const clash = (one: Label) =>
    kept.some((other) => {
      const [dx, dy] = [0, 1].map((k) => Math.abs((one.at[k] - other.at[k]) / unit + 16 * (one.off[k] - other.off[k])));
      return dx < 4 * (one.text.length + other.text.length) && dy < 13;
    });
  for (const label of labels) {
    const other = { ...label, off: [-label.off[0], -label.off[1]] as Place };
    const free = [label, other].find((one) => !clash(one));
    if (free) kept.push(free);
  }
  return kept;
}

function away(at: Place, name: string, outline: Outline, places: Map<string, Place>): Place {
  let [x, y] = [0, 0];
  for (const { points } of outline.strokes) {
    if (!points.includes(name)) continue;
    for (const other of points) {
      const to = places.get(other)!;
      const size = Math.hypot(to[0] - at[0], to[1] - at[1]);
      if (size > 0) [x, y] = [x - (to[0] - at[0]) / size, y - (to[1] - at[1]) / size];
    }
  }
  const size = Math.hypot(x, y);
  return size > 0.2 ? [x / size, y / size] : [0.3, 1];
}
