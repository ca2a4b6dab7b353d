// Numbers with units, as engineers write them.

const PREFIXES = [
  [1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"], [1e-12, "p"],
  [1e-15, "f"], [1e-18, "a"],
];

// Factor and unit in which `largest` has one to three digits before the point.
function scaled(largest, unit) {
  if (unit === "%") return { factor: 0.01, unit: "%" };
  if (!unit || unit.startsWith("kg") || !(largest > 0)) return { factor: 1, unit }; // kg has its prefix
  const [factor, prefix] = PREFIXES.find(([value]) => largest >= value * 0.9999) ?? PREFIXES.at(-1);
  return { factor, unit: prefix + unit };
}

// A number in at most `digits` significant ones.
function short(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e6 || size < 1e-4)) return value.toExponential(Math.min(digits - 1, 2)).replace("e+", "e").replace("-", "−");
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}

function quantity(value, unit, digits = 4) {
  const { factor, unit: name } = scaled(Math.abs(value), unit);
  return `${short(value / factor, digits)} ${name}`.trim();
}

// The largest of 1, 2, 5 times a power of ten that is at most `limit`.
function niceBelow(limit) {
  const power = 10 ** Math.floor(Math.log10(limit));
  return [5, 2, 1].find((digit) => digit * power <= limit * 1.0001) * power;
}

// Round values between two ends, some `count` of them.
function ticks(low, high, count = 5) {
  if (!(high > low)) return [low];
  const step = niceBelow((high - low) / (count - 1)) ;
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return found;
}
