// Numbers and names as people read them.
import type { Value } from "./types";

/** Ten significant digits; symbols with their apostrophe, nothing where there is no value. */
export function readable(value: Value | null | undefined, digits = 10): string {
  if (value === null || value === undefined) return "";
  if (typeof value === "string") return `'${value}`;
  return String(Number(value.toPrecision(digits)) + 0).replace("-", "−");
}

/** An input as it is typed. */
export function typed(value: Value | null | undefined): string {
  if (value === null || value === undefined) return "";
  return typeof value === "string" ? `'${value}` : String(value + 0);
}

/** A number written in digits, if that is what the text is. */
export function plainNumber(text: string): number | undefined {
  const clean = text.trim().replace("−", "-");
  return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(clean) && Number.isFinite(Number(clean)) ? Number(clean) : undefined;
}

/** A round step: 1, 2 or 5 times a power of ten, not above `size`. */
export function niceStep(size: number): number {
  const power = 10 ** Math.floor(Math.log10(size));
  const lead = size / power;
  return Number(((lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power).toPrecision(1));
}

/** The least of 1, 2 or 5 times a power of ten that is not below `size`. */
export function roundAbove(size: number): number {
  const power = 10 ** Math.floor(Math.log10(size));
  return [1, 2, 5, 10].map((lead) => lead * power).find((one) => one >= size * (1 - 1e-9)) ?? 10 * power;
}

/** The nearest multiple of a step, without the noise of its power of ten. */
export function rounded(value: number, step: number): number {
  const digits = Math.max(0, Math.min(15, Math.ceil(-Math.log10(step)) + 1));
  return Number((Math.round(value / step) * step).toFixed(digits)) + 0;
}

export function plural(count: number, noun: string): string {
  return `${count} ${noun}${count === 1 ? "" : "s"}`;
}
