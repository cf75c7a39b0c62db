// Colours as red, green, blue in 0 to 255.
export function rgb(hex) {
  const number = parseInt(hex.slice(1), 16);
  return [number >> 16, (number >> 8) & 255, number & 255];
}

// `fade` 1 is the colour itself, 0 the ground: opaque, so that nothing has to be sorted.
export function mix(colour, ground, fade, out, at = 0) {
  for (let i = 0; i < 3; i++) out[at + i] = Math.round(ground[i] + (colour[i] - ground[i]) * fade);
  return out;
}

export const css = (colour) => `rgb(${colour[0]},${colour[1]},${colour[2]})`;

export const palette = (colours) =>
  Object.fromEntries(Object.entries(colours).map(([name, hex]) => [name, rgb(hex)]));
