// Positions of the take, float32, in chunks around the cursor: asked for as playback nears them,
// forgotten when they are far away and memory is short.
const KEPT_BYTES = 96e6;

export class PositionStore {
  constructor(request) {
    this.request = request;
    this.reset({ id: "", n_frames: 0, n_markers: 0, chunk_frames: 1 });
  }

  reset(take) {
    this.take = take;
    this.chunks = new Map(); // in order of use
    this.asked = new Set();
    this.stride = take.n_markers * 3;
  }

  get nChunks() {
    return Math.ceil(this.take.n_frames / this.take.chunk_frames);
  }

  chunkOf(frame) {
    return Math.floor(frame / this.take.chunk_frames);
  }

  has(frame) {
    return this.chunks.has(this.chunkOf(frame));
  }

  // Ask for what frames in [start, stop) need and is not here.
  want(start, stop) {
    const first = Math.max(0, this.chunkOf(start));
    const last = Math.min(this.nChunks - 1, this.chunkOf(Math.max(start, stop - 1)));
    for (let chunk = first; chunk <= last; chunk++) {
      if (this.chunks.has(chunk) || this.asked.has(chunk)) continue;
      this.asked.add(chunk);
      this.request({ type: "want", take: this.take.id, chunk });
    }
  }

  receive({ take, chunk, data }) {
    if (take !== this.take.id) return false; // late, of a take that is no longer shown
    this.asked.delete(chunk);
    this.chunks.set(chunk, new Float32Array(data));
    const bytes = this.take.chunk_frames * this.stride * 4;
    while (this.chunks.size > 4 && this.chunks.size * bytes > KEPT_BYTES) {
      this.chunks.delete(this.chunks.keys().next().value);
    }
    return true;
  }

  // Values that changed since they were sent, such as an accepted repair: from `start` on.
  patch({ take, marker, start, data }) {
    if (take !== this.take.id) return;
    const values = new Float32Array(data);
    for (let i = 0; i < values.length / 3; i++) {
      const chunk = this.chunks.get(this.chunkOf(start + i));
      if (!chunk) continue;
      const at = ((start + i) % this.take.chunk_frames) * this.stride + 3 * marker;
      chunk.set(values.subarray(3 * i, 3 * i + 3), at);
    }
  }

  // Keep what lies around this frame longest.
  touch(frame) {
    const number = this.chunkOf(frame);
    const chunk = this.chunks.get(number);
    if (!chunk) return;
    this.chunks.delete(number);
    this.chunks.set(number, chunk);
  }

  // All markers of a frame, (n_markers * 3), or null while it is on its way.
  frame(frame) {
    const chunk = this.chunks.get(this.chunkOf(frame));
    if (!chunk) return null;
    const at = (frame % this.take.chunk_frames) * this.stride;
    return chunk.subarray(at, at + this.stride);
  }
}
