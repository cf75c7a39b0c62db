// What is to be seen at one frame: where every marker is, how far away, and the paths of the
// selected one. Painters draw it and know nothing of takes and findings.
export const MARKER_MM = 14;
export const SELECTED_MM = 18;
export const BONE_MM = 5.5;
const MIN_PIXELS = { marker: 2.6, selected: 5, bone: 0.8 };
const FARTHEST_FADE = 0.42;
const SMOOTHING_S = 0.4;

export class Picture {
  constructor(trailPoints) {
    this.trail = new Float32Array(3 * trailPoints);
    this.rawTrail = new Float32Array(3 * trailPoints);
    this.point = [0, 0, 0];
    this.resize(0);
  }

  resize(nMarkers) {
    this.n = nMarkers;
    this.xyz = new Float32Array(3 * nMarkers);
    this.screen = new Float32Array(3 * nMarkers);
    this.seen = new Uint8Array(nMarkers);
    this.fade = new Float32Array(nMarkers); // 1 near, FARTHEST_FADE at the far side of the body
    this.selected = -1;
    this.neighbours = [];
    this.ghost = null;
    this.hasRaw = false;
    this.complete = false;
  }

  // Where a marker is at a frame, the chosen repair included; false where it is not seen.
  at(scene, marker, frame, out) {
    const { focus, store } = scene;
    if (focus?.repaired && marker === focus.marker && frame >= focus.start && frame < focus.stop) {
      return copy(focus.repaired, 3 * (frame - focus.start), out);
    }
    const values = store.frame(frame);
    return values !== null && copy(values, 3 * marker, out);
  }

  rawAt(scene, frame, out) {
    const { focus } = scene;
    if (frame >= focus.start && frame < focus.stop) {
      return copy(focus.raw, 3 * (frame - focus.start), out);
    }
    const beside = frame === focus.start - 1 || frame === focus.stop;
    const values = beside ? scene.store.frame(frame) : null;
    return values !== null && copy(values, 3 * focus.marker, out);
  }

  // Returns whether the frame is here; else the picture stays as it was.
  compose(scene, frame) {
    const values = scene.store.frame(frame);
    if (values === null) return false;
    this.xyz.set(values);
    const { focus } = scene;
    const shown = focus && focus.marker === scene.selected ? focus : null;
    if (focus?.repaired && this.at(scene, focus.marker, frame, this.point)) {
      this.xyz.set(this.point, 3 * focus.marker);
    } else if (focus?.repaired && frame >= focus.start && frame < focus.stop) {
      this.xyz.fill(NaN, 3 * focus.marker, 3 * focus.marker + 3);
    }
    for (let i = 0; i < this.n; i++) this.seen[i] = this.xyz[3 * i] === this.xyz[3 * i] ? 1 : 0;

    this.selected = scene.selected;
    this.neighbours = shown ? shown.neighbours : [];
    this.colour = shown?.colour;
    this.hasRaw = Boolean(shown?.raw);
    this.inSpan = Boolean(shown) && frame >= focus.start && frame < focus.stop;
    this.ghost = null;
    if (this.hasRaw && this.inSpan && this.rawAt(scene, frame, this.point)) {
      this.ghost = [...this.point];
    }
    this.composeTrails(scene, frame);
    this.complete = true;
    return true;
  }

  composeTrails(scene, frame) {
    this.trail.fill(NaN);
    this.rawTrail.fill(NaN);
    const half = Math.round(scene.trailS * scene.take.rate);
    if (scene.selected < 0 || half < 1) return;
    // Whole multiples of the stride, so that the path itself stands still while it is travelled.
    const stride = Math.max(1, Math.ceil((2 * half) / (this.trail.length / 3 - 2)));
    const first = Math.ceil(Math.max(0, frame - half) / stride) * stride;
    const last = Math.min(scene.take.n_frames - 1, frame + half);
    for (let f = first, k = 0; f <= last; f += stride, k += 3) {
      if (this.at(scene, scene.selected, f, this.point)) this.trail.set(this.point, k);
      if (this.hasRaw && this.rawAt(scene, f, this.point)) this.rawTrail.set(this.point, k);
    }
  }

  // Screen positions and depth fading, for the camera as it is now.
  project(camera) {
    let near = Infinity, far = -Infinity;
    for (let i = 0; i < this.n; i++) {
      if (!this.seen[i]) continue;
      const k = 3 * i;
      camera.project(this.xyz[k], this.xyz[k + 1], this.xyz[k + 2], this.screen, k);
      near = Math.min(near, this.screen[k + 2]);
      far = Math.max(far, this.screen[k + 2]);
    }
    const range = Math.max(far - near, 1);
    for (let i = 0; i < this.n; i++) {
      const depth = (this.screen[3 * i + 2] - near) / range;
      this.fade[i] = 1 - (1 - FARTHEST_FADE) * depth;
    }
  }

  // Around the selected marker: its kind's colour within the span, unless the raw ring shows it.
  outline(colours) {
    return this.inSpan && !this.ghost ? this.colour : colours.panel;
  }

  // Radius in mm, never less than can be seen on the screen.
  radius(i, camera) {
    const [mm, px] = i === this.selected
      ? [SELECTED_MM, MIN_PIXELS.selected] : [MARKER_MM, MIN_PIXELS.marker];
    return Math.max(mm, px * camera.millimetres(this.screen[3 * i + 2]));
  }

  boneRadius(depth, camera) {
    return Math.max(BONE_MM, MIN_PIXELS.bone * camera.millimetres(depth));
  }

  // The marker under a point of the screen, or -1; of several the nearest to the eye.
  pick(x, y, reach = 11) {
    let best = -1, bestCost = Infinity;
    for (let i = 0; i < this.n; i++) {
      if (!this.seen[i]) continue;
      const away = Math.hypot(this.screen[3 * i] - x, this.screen[3 * i + 1] - y);
      const cost = away + 4 * (1 - this.fade[i]);
      if (away <= reach && cost < bestCost) [best, bestCost] = [i, cost];
    }
    return best;
  }
}

// Middle of the seen markers, smoothed over time so that a camera may follow it.
export function centreAt(scene, frame) {
  const reach = Math.round(SMOOTHING_S * scene.take.rate);
  const sum = [0, 0, 0];
  let samples = 0;
  for (let s = -4; s <= 4; s++) {
    const values = scene.store.frame(clip(frame + Math.round((s * reach) / 4), scene.take.n_frames));
    const middle = values && mean(values);
    if (!middle) continue;
    for (let i = 0; i < 3; i++) sum[i] += middle[i];
    samples++;
  }
  return samples ? sum.map((v) => v / samples) : null;
}

// Where the subject faces, in radians: from left and right markers, else by how it moves.
export function headingAt(scene, frame) {
  const values = scene.store.frame(frame);
  if (!values) return 0;
  const left = mean(values, (i) => scene.sides[i] > 0);
  const right = mean(values, (i) => scene.sides[i] < 0);
  if (left && right) return Math.atan2(left[1] - right[1], left[0] - right[0]) - Math.PI / 2;
  const n = scene.take.n_frames;
  const before = scene.store.frame(clip(frame - Math.round(scene.take.rate / 2), n));
  const after = scene.store.frame(clip(frame + Math.round(scene.take.rate / 2), n));
  const from = before && mean(before), to = after && mean(after);
  return from && to ? Math.atan2(to[1] - from[1], to[0] - from[0]) : 0;
}

const clip = (frame, n) => Math.min(n - 1, Math.max(0, frame));

function copy(values, at, out) {
  if (values[at] !== values[at]) return false;
  out[0] = values[at];
  out[1] = values[at + 1];
  out[2] = values[at + 2];
  return true;
}

function mean(values, among = () => true) {
  const sum = [0, 0, 0];
  let n = 0;
  for (let i = 0; i < values.length / 3; i++) {
    if (values[3 * i] !== values[3 * i] || !among(i)) continue;
    for (let k = 0; k < 3; k++) sum[k] += values[3 * i + k];
    n++;
  }
  return n ? sum.map((v) => v / n) : null;
}
