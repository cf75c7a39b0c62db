// The clock of playback: turns the browser's time into frames.
export class Player {
  constructor() {
    this.frame = 0;
    this.playing = false;
    this.speed = 1;
    this.loop = null;
    this.rate = 100;
    this.nFrames = 1;
    this.restart();
  }

  // Time counts from here on; called whenever anything but the time itself changed.
  restart() {
    this.since = null;
    this.from = this.frame;
  }

  seek(frame) {
    this.frame = Math.min(this.nFrames - 1, Math.max(0, Math.round(frame)));
    this.restart();
  }

  set(changes) {
    Object.assign(this, changes);
    this.restart();
  }

  // The range that is played: the loop while the cursor is in it, else the take.
  get range() {
    const [start, stop] = this.loop ?? [0, this.nFrames];
    return [Math.max(0, start), Math.min(this.nFrames, stop)];
  }

  // Which frame is due at this time; the frame is not moved yet, since it may still be on its way.
  due(now) {
    if (!this.playing) return this.frame;
    if (this.since === null) {
      this.since = now;
      const [start, stop] = this.range;
      if (this.from < start || this.from >= stop) this.from = start;
    }
    const [start, stop] = this.range;
    const passed = ((now - this.since) / 1000) * this.rate * this.speed;
    return start + Math.floor((this.from - start + passed) % (stop - start));
  }
}
