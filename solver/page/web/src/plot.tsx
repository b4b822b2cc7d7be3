// Small plots of a sweep, one above the other, with a cursor that follows the sheet.
import { readable, roundAbove } from "./format";

export interface Series {
  name: string;
  unit: string;
  values: (number | null)[];
}

interface Props {
  x: number[];
  name: string;
  series: Series;
  cursor: number | null;
  here: number | null;
  pick: (x: number) => void;
}

const [W, H, L, R, T, B] = [420, 150, 62, 12, 10, 24];

export function Plot({ x, name, series, cursor, here, pick }: Props) {
  const known = series.values.filter((one): one is number => one !== null);
  if (!known.length) return null;
  const [x0, x1] = [Math.min(...x), Math.max(...x)];
  let [y0, y1] = [Math.min(...known), Math.max(...known)];
  if (y1 - y0 < 1e-12 * Math.max(Math.abs(y0), 1e-300)) [y0, y1] = [y0 - 1, y1 + 1];
  const px = (at: number) => L + ((at - x0) / (x1 - x0 || 1)) * (W - L - R);
  const py = (at: number) => H - B - ((at - y0) / (y1 - y0)) * (H - T - B);
  const choose = (event: MouseEvent) => {
    const box = (event.currentTarget as SVGElement).getBoundingClientRect();
    const at = x0 + ((((event.clientX - box.left) / box.width) * W - L) / (W - L - R)) * (x1 - x0);
    pick(x.reduce((best, one) => (Math.abs(one - at) < Math.abs(best - at) ? one : best)));
  };
  return (
    <figure class="plot">
      <figcaption>
        {series.name}
        {series.unit && <small> {series.unit}</small>}
      </figcaption>
      <svg viewBox={`0 0 ${W} ${H}`} role="img" aria-label={`${series.name} over ${name}`} onClick={choose}>
        {ticks(y0, y1, 5).map((at) => (
          <g key={at} class="grid">
            <line x1={L} x2={W - R} y1={py(at)} y2={py(at)} />
            <text x={L - 6} y={py(at) + 3.5} text-anchor="end">
              {readable(at, 6)}
            </text>
          </g>
        ))}
        {ticks(x0, x1, 6).map((at) => (
          <g key={at} class="grid">
            <line x1={px(at)} x2={px(at)} y1={T} y2={H - B} />
            <text x={px(at)} y={H - B + 14} text-anchor="middle">
              {readable(at, 6)}
            </text>
          </g>
        ))}
        <path class="curve" d={curve(x, series.values, px, py)} />
        {cursor !== null && cursor >= x0 && cursor <= x1 && (
          <line class="cursor" data-x={cursor} x1={px(cursor)} x2={px(cursor)} y1={T} y2={H - B} />
        )}
        {cursor !== null && here !== null && cursor >= x0 && cursor <= x1 && here >= y0 && here <= y1 && (
          <circle class="cursor" cx={px(cursor)} cy={py(here)} r={3.5} />
        )}
      </svg>
    </figure>
  );
}

function curve(x: number[], values: (number | null)[], px: (at: number) => number, py: (at: number) => number): string {
  let text = "";
  let drawing = false;
  const known = values.filter((one): one is number => one !== null);
  // a leap over most of the range is a pole or a jump, and no line
  const leap = known.length < 10 ? Infinity : 0.7 * (Math.max(...known) - Math.min(...known));
  values.forEach((value, k) => {
    const before = values[k - 1];
    if (value === null || (typeof before === "number" && Math.abs(value - before) > leap)) drawing = false;
    if (value !== null) {
      text += `${drawing ? "L" : "M"}${px(x[k]).toFixed(2)},${py(value).toFixed(2)}`;
      drawing = true;
    }
  });
  return text;
}

/** Multiples of a round step within a range, about so many. */
function ticks(low: number, high: number, count: number): number[] {
  const step = roundAbove((high - low) / count);
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  if (!(last - first < 50)) return [];
  return Array.from({ length: last - first + 1 }, (_, k) => Number(((first + k) * step).toPrecision(10)) + 0);
}
