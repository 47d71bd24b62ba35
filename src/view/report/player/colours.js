/** Palette of Okabe and Ito, suited to colour-blind readers. */
const PALETTE = [
  [86, 180, 233], [230, 159, 0], [0, 158, 115], [213, 94, 0], [0, 114, 178], [204, 121, 167], [240, 228, 66], [120, 120, 120],
];

/** The Viridis colour map (Smith and van der Walt) at even steps. */
const VIRIDIS = [
  [68, 1, 84], [72, 36, 117], [65, 68, 135], [53, 95, 141], [42, 120, 142], [33, 145, 140],
  [34, 168, 132], [68, 191, 112], [122, 209, 81], [189, 223, 38], [253, 231, 37],
];

const css = (colour) => `rgb(${colour.join(" ")})`;

function scaleColours() {
  return [...Array(256).keys()].map((k) => {
    const place = (k / 255) * (VIRIDIS.length - 1);
    const index = Math.min(Math.floor(place), VIRIDIS.length - 2);
    return VIRIDIS[index].map((x, part) => Math.round(x + (place - index) * (VIRIDIS[index + 1][part] - x)));
  });
}

function speciesColours(species, fixed) {
  let next = 0;
  return species.map(({ isStatic }) => (isStatic ? fixed : PALETTE[next++ % PALETTE.length]));
}

const short = (x) => String(Number(x.toPrecision(4)));

const raised = (unit) => unit.replace(/\^(-?\d+)/g, (_, digits) => [...digits].map((d) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(d)]).join(""));

function decoded(text) {
  if (Uint8Array.fromBase64) {
    return Uint8Array.fromBase64(text);
  }
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let k = 0; k < letters.length; k += 1) {
    bytes[k] = letters.charCodeAt(k);
  }
  return bytes;
}
