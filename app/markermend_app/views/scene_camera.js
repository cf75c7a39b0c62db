// A camera that orbits a target; z is up, lengths are millimetres. Both painters draw through it.
export const MIN_ELEVATION = -0.15;
export const MAX_ELEVATION = Math.PI / 2 - 0.01;

const LEFT_OF_CENTRE = 0.05; // of the width: the lens is at the right

export const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

export class OrbitCamera {
  constructor() {
    this.azimuth = 0.9;
    this.elevation = 0.17;
    this.distance = 4500;
    this.angle = (26 * Math.PI) / 180;
    this.target = [0, 0, 900];
    this.offset = [0, 0, 0]; // what the user panned; stays when the target follows the subject
    this.resize(1, 1);
  }

  resize(width, height) {
    this.width = width;
    this.height = height;
    this.update();
  }

  // Everything that projecting needs, once for each picture.
  update() {
    const { azimuth: a, elevation: e } = this;
    const back = [Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e)];
    this.right = [-Math.sin(a), Math.cos(a), 0];
    this.up = cross(back, this.right);
    this.back = back;
    this.pixels = this.height / 2 / Math.tan(this.angle / 2); // pixels for a slope of 1
    const aside = LEFT_OF_CENTRE * this.width * this.millimetres(this.distance);
    this.focal = [0, 1, 2].map((i) => this.target[i] + this.offset[i] + aside * this.right[i]);
    this.position = [0, 1, 2].map((i) => this.focal[i] + this.distance * back[i]);
  }

  // Screen x and y in CSS pixels, and depth along the view; written into `out` at `at`.
  project(x, y, z, out, at = 0) {
    const { position: p, right: r, up: u, back: b } = this;
    const dx = x - p[0], dy = y - p[1], dz = z - p[2];
    const depth = -(dx * b[0] + dy * b[1] + dz * b[2]);
    const scale = this.pixels / Math.max(depth, 1);
    out[at] = this.width / 2 + (dx * r[0] + dy * r[1]) * scale;
    out[at + 1] = this.height / 2 - (dx * u[0] + dy * u[1] + dz * u[2]) * scale;
    out[at + 2] = depth;
  }

  millimetres(depth) {
    return Math.max(depth, 1) / this.pixels; // of one pixel
  }

  orbit(dx, dy) {
    this.azimuth -= dx * 0.008;
    const elevation = this.elevation + dy * 0.008;
    this.elevation = Math.min(MAX_ELEVATION, Math.max(MIN_ELEVATION, elevation));
  }

  pan(dx, dy) {
    const mm = this.millimetres(this.distance);
    for (let i = 0; i < 3; i++) this.offset[i] += (-dx * this.right[i] + dy * this.up[i]) * mm;
  }

  zoom(factor) {
    this.distance = Math.min(60000, Math.max(150, this.distance * factor));
  }

  // Show a subject of this size; `from` is a preset, `heading` where the subject faces.
  frame(size, from, heading) {
    const turns = { front: [0, 0.06], side: [Math.PI / 2, 0.06], top: [0, MAX_ELEVATION] };
    const [turn, elevation] = turns[from] ?? [0.75, 0.16];
    const isPicture = size[1] <= 1; // a take in two dimensions stands in the plane y = 0
    this.azimuth = isPicture ? -Math.PI / 2 : heading + turn;
    this.elevation = isPicture ? 0 : elevation;
    this.offset = [0, 0, 0];
    const flat = Math.hypot(size[0], size[1]);
    const tall = from === "top" ? flat : size[2];
    const aspect = Math.max(this.width / this.height, 0.1);
    this.distance = (1.3 * Math.max(tall, flat / aspect)) / 2 / Math.tan(this.angle / 2) + flat / 2;
  }
}
