// Numbers as people read them.

/** The next of 1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8 times a power of ten that is not below, but for what single precision rounds. */
export function roundedUp(value: number): number {
  if (!(value > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(value));
  const digit = [1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10].find((d) => d * power * (1 + 1e-6) >= value)!;
  return Number((digit * power).toPrecision(2));
}

/** From 0 to the end, at most six steps. */
export function ticks(end: number): number[] {
  const step = [0.2, 0.25, 0.5, 1].map((part) => part * end).find((s) => Number(s.toPrecision(1)) === Number(s.toPrecision(6))) ?? end / 4;
  const count = Math.round(end / step);
  return Array.from({ length: count + 1 }, (_, i) => Number((i * step).toPrecision(4)));
}

/** Three digits that count, without an exponent where it can be helped. */
export function short(value: number): string {
  if (Number.isNaN(value)) return '–';
  if (!Number.isFinite(value)) return value > 0 ? '∞' : '−∞';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size < 1e-5 || size >= 1e6) return value.toExponential(1).replace('-', '−').replace('e−', 'e−');
  const decimals = Math.max(0, 2 - Math.floor(Math.log10(Number(size.toPrecision(3)))));
  return value.toFixed(Math.min(decimals, 7)).replace('-', '−');
}

export const millimetres = (metres: number) => short(1000 * metres);

/** A ratio in per cent; what is nothing but rounding is 0. */
export function percent(ratio: number): string {
  if (Math.abs(ratio) < 5e-7) return '0';
  return Math.abs(ratio) < 5e-5 ? '< 0.01' : short(100 * ratio);
}
