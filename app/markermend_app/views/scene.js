import { OrbitCamera } from "./scene_camera.js";
import { CanvasPainter } from "./scene_canvas.js";
import { palette, rgb } from "./scene_colour.js";
import { Surround } from "./scene_frame.js";
import { Lens } from "./scene_lens.js";
import { announceFrame, connectPage, throttled } from "./scene_page.js";
import { centreAt, headingAt, Picture } from "./scene_picture.js";
import { Player } from "./scene_player.js";
import { PositionStore } from "./scene_store.js";
import { WebGLPainter } from "./scene_webgl.js";

const REPORT_MS = 100;
const AHEAD_S = 4; // of playback that is asked for before it is due

// Bokeh hands dictionaries over as objects or as maps.
function plain(value) {
  if (!(value instanceof Map)) return value;
  return Object.fromEntries([...value].map(([key, item]) => [key, plain(item)]));
}

function loadVtk(url) {
  if (window.vtk) return Promise.resolve(window.vtk);
  return new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = url;
    script.onload = () => resolve(window.vtk);
    script.onerror = () => reject(new Error(`${url} could not be loaded`));
    document.head.append(script);
  });
}

class SceneView {
  constructor(model, el) {
    this.model = model;
    this.surround = new Surround(el);
    this.lens = new Lens(this.surround.lens.querySelector("canvas"));
    this.camera = new OrbitCamera();
    this.player = new Player();
    this.store = new PositionStore((message) => model.send_msg(message));
    this.painter = null;
    this.drawn = 0;
    this.drawnFrame = -1;
    this.dirty = true;
    this.reported = -1;
    this.report = throttled((frame) => this.tellPython(frame), REPORT_MS);
    this.take = { id: "", n_frames: 0, n_markers: 0, rate: 100, bones: [], labels: [] };
    this.picture = new Picture(2);
    this.listen();
    this.takeColours();
    this.takeScene();
    this.takeFocus();
    this.takePlayback();
    this.tick = this.tick.bind(this);
    this.ticking = requestAnimationFrame(this.tick);
    this.start();
  }

  async start() {
    if (WebGLPainter.available()) {
      try {
        const vtk = await loadVtk(this.model.vtk_url);
        if (this.removed) return;
        this.use(new WebGLPainter(vtk, this.surround.draw, () => this.useCanvas()));
        return;
      } catch (error) {
        console.error(`The 3D view is drawn without WebGL: ${error.message}.`);
      }
    }
    this.useCanvas();
  }

  useCanvas() {
    this.painter?.dispose();
    this.surround.draw.replaceChildren();
    this.use(new CanvasPainter(this.surround.draw));
    this.surround.say("Simpler drawing: this browser has no WebGL.");
  }

  use(painter) {
    this.painter = painter;
    if (this.take.n_frames) painter.setScene(this.meshes, this.take);
    this.resize();
  }

  // What Python shows -----------------------------------------------------------------------

  takeScene() {
    const scene = plain(this.model.scene);
    if (!scene.n_frames || scene.id === this.take.id) return;
    this.meshes = scene.meshes;
    const lines = new Uint32Array(scene.meshes.skeleton.lines ?? 0);
    this.take = { ...scene, bones: lines.filter((_, k) => k % 3 > 0) }; // each line: 2, from, to
    this.sides = new Int8Array(scene.sides);
    this.store.reset(this.take);
    this.picture = new Picture(this.take.trail_points);
    this.picture.resize(this.take.n_markers);
    this.player.set({ nFrames: this.take.n_frames, rate: this.take.rate });
    this.player.seek(this.model.frame);
    this.cameraDue = true;
    this.drawnFrame = -1;
    this.painter?.setScene(this.meshes, this.take);
    this.wantAround(this.player.frame);
    this.dirty = true;
  }

  takeFocus() {
    const focus = plain(this.model.focus);
    this.focus = null;
    if (focus && focus.marker !== undefined && focus.take === this.take.id) {
      this.focus = {
        ...focus,
        colour: rgb(focus.colour),
        raw: focus.raw && new Float32Array(focus.raw),
        repaired: focus.repaired && new Float32Array(focus.repaired),
      };
    }
    this.selected = this.model.selected < this.take.n_markers ? this.model.selected : -1;
    this.trailS = this.model.trail;
    this.dirty = true;
  }

  takeColours() {
    const colours = plain(this.model.colours);
    this.surround.setColours(colours);
    this.colours = palette(colours);
    this.dirty = true;
  }

  takePlayback() {
    const { playing, speed, loop } = this.model;
    const paused = this.player.playing && !playing;
    this.player.set({ playing, speed, loop: loop?.length === 2 ? [...loop] : null });
    if (paused) this.report.now(this.player.frame);
    this.dirty = true;
  }

  takeView() {
    this.cameraDue ||= this.model.view !== "free";
    this.dirty = true;
  }

  takeFrame() {
    if (this.model.frame !== this.reported) this.seek(this.model.frame, false);
  }

  // What the operator does ------------------------------------------------------------------

  listen() {
    const { model } = this;
    const on = (names, handle) => model.on(names, handle.bind(this));
    on(["scene"], () => {
      this.takeScene();
      this.takeFocus();
    });
    on(["focus", "selected", "trail"], this.takeFocus);
    on(["colours"], this.takeColours);
    on(["playing", "speed", "loop"], this.takePlayback);
    on(["frame"], this.takeFrame);
    on(["view"], this.takeView);
    on(["follow"], () => (this.dirty = true));
    on(["msg:custom"], (message) => this.receive(plain(message)));
    on(["remove"], this.remove);
    this.resizing = new ResizeObserver(() => this.resize());
    this.resizing.observe(this.surround.draw);
    this.disconnectPage = connectPage({
      onSeek: ({ frame, time }) => this.seek(frame ?? time * this.take.rate, true),
      onStep: (by) => {
        model.playing = false;
        this.seek(this.player.frame + by, true);
      },
      onPlay: (playing) => (model.playing = playing ?? !model.playing),
    });
    this.listenToPointer(this.surround.draw);
  }

  listenToPointer(draw) {
    const { model } = this;
    let last = null, travelled = 0;
    draw.addEventListener("pointerdown", (event) => {
      draw.setPointerCapture(event.pointerId);
      last = [event.clientX, event.clientY];
      travelled = 0;
    });
    draw.addEventListener("pointermove", (event) => {
      if (!last) return;
      const dx = event.clientX - last[0], dy = event.clientY - last[1];
      last = [event.clientX, event.clientY];
      travelled += Math.abs(dx) + Math.abs(dy);
      if (travelled < 4) return;
      if (event.shiftKey || event.buttons & 6) {
        this.camera.pan(dx, dy);
      } else {
        this.camera.orbit(dx, dy);
        if (model.view !== "free") model.view = "free";
      }
      this.dirty = true;
    });
    draw.addEventListener("pointerup", (event) => {
      last = null;
      if (travelled < 4 && event.button === 0) this.pick(event);
    });
    draw.addEventListener("pointercancel", () => (last = null));
    draw.addEventListener("contextmenu", (event) => event.preventDefault());
    draw.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.camera.zoom(Math.exp(event.deltaY * 0.0012));
      this.dirty = true;
    }, { passive: false });
  }

  pick(event) {
    const box = this.surround.draw.getBoundingClientRect();
    const marker = this.picture.pick(event.clientX - box.left, event.clientY - box.top);
    if (marker < 0 || marker === this.selected) return;
    this.selected = marker; // seen at once; Python says the same a moment later
    this.dirty = true;
    this.model.send_msg({ type: "pick", take: this.take.id, marker });
  }

  seek(frame, tell) {
    if (!this.take.n_frames) return;
    this.player.seek(frame);
    this.wantAround(this.player.frame);
    this.dirty = true;
    if (tell) this.report.push(this.player.frame);
  }

  receive(message) {
    if (message.type === "chunk" && this.store.receive(message)) this.dirty = true;
    if (message.type === "patch") {
      this.store.patch(message);
      this.dirty = true;
    }
  }

  tellPython(frame) {
    this.reported = frame;
    this.model.frame = frame;
  }

  // Drawing ---------------------------------------------------------------------------------

  wantAround(frame) {
    const around = Math.ceil((this.trailS ?? 0.5) * this.take.rate);
    const ahead = this.player.playing ? Math.ceil(AHEAD_S * this.player.speed * this.take.rate) : 0;
    this.store.want(frame - around, frame + Math.max(around, ahead) + 1);
    if (this.player.loop) this.store.want(...this.player.range);
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.surround.draw;
    if (!width || !height || !this.painter) return;
    this.ratio = Math.min(window.devicePixelRatio || 1, 2);
    this.camera.resize(width, height);
    this.painter.resize(width, height, this.ratio);
    this.dirty = true;
    this.draw();
  }

  tick(now) {
    this.ticking = requestAnimationFrame(this.tick);
    const { player } = this;
    if (player.playing && this.take.n_frames) {
      const due = player.due(now);
      if (due !== player.frame) {
        this.wantAround(due);
        if (this.store.has(due)) {
          player.frame = due;
          this.dirty = true;
          this.report.push(due);
        } else {
          player.restart(); // wait for it
        }
      }
    }
    if (this.dirty) this.draw();
  }

  draw() {
    if (!this.painter || !this.take.n_frames || this.camera.width <= 1) return;
    const { camera, picture, player, surround } = this;
    this.store.touch(player.frame);
    const here = picture.compose(this, player.frame);
    if (!here && !picture.complete) return;
    this.dirty = !here;
    this.aim(player.frame);
    camera.update();
    picture.project(camera);
    this.painter.paint(picture, camera, this.colours);
    surround.setLegend(picture, this.colours);
    const label = this.take.labels[picture.selected] ?? "";
    surround.placeLabel(picture, camera, label);
    const lens = this.focus?.marker === this.selected && Lens.aim(picture) !== null;
    surround.lens.hidden = !lens;
    if (lens) this.lens.paint(picture, camera, this.colours, this.ratio);
    this.drawn++;
    if (here && this.drawnFrame !== player.frame) {
      this.drawnFrame = player.frame;
      if (!player.playing) surround.describe(label, player.frame);
      const { frame, playing } = player;
      announceFrame({ frame, time: frame / this.take.rate, playing });
    }
  }

  aim(frame) {
    if (this.cameraDue && this.store.has(frame)) {
      this.cameraDue = false;
      this.camera.frame(this.take.size, this.model.view, headingAt(this, frame));
      this.camera.target = [...this.take.centre];
    }
    const centre = this.model.follow && centreAt(this, frame);
    if (centre) this.camera.target = [centre[0], centre[1], this.take.centre[2]];
  }

  remove() {
    this.removed = true;
    cancelAnimationFrame(this.ticking);
    this.report.stop();
    this.resizing.disconnect();
    this.disconnectPage();
    this.painter?.dispose();
    if (window.markermendScene?.owner === this) delete window.markermendScene;
  }
}

// What is drawn, for tests and for curious people; nothing here changes anything.
function debugging(scene) {
  return {
    owner: scene,
    get frame() { return scene.drawnFrame; },
    get drawn() { return scene.drawn; },
    get playing() { return scene.player.playing; },
    get renderer() { return scene.painter?.name ?? null; },
    get ready() { return scene.drawnFrame >= 0; },
    get selected() { return scene.picture.selected; },
    get neighbours() { return [...scene.picture.neighbours]; },
    get chunks() { return scene.store.chunks.size; },
    get camera() {
      const { azimuth, elevation, distance, focal } = scene.camera;
      return { azimuth, elevation, distance, focal: [...focal] };
    },
    // Where a marker is on the page, in CSS pixels, or null where it is not seen.
    markerPixel(i) {
      if (!scene.picture.seen[i]) return null;
      const box = scene.surround.draw.getBoundingClientRect();
      return [box.left + scene.picture.screen[3 * i], box.top + scene.picture.screen[3 * i + 1]];
    },
    ghostPixel() {
      if (!scene.picture.ghost) return null;
      const box = scene.surround.draw.getBoundingClientRect(), at = [0, 0, 0];
      scene.camera.project(...scene.picture.ghost, at);
      return [box.left + at[0], box.top + at[1]];
    },
    // The colour that is really there, read back from the drawing.
    colourAt(x, y) {
      const box = scene.surround.draw.getBoundingClientRect();
      return scene.painter.colourAt(x - box.left, y - box.top, scene.ratio);
    },
  };
}

// A component may be rendered anew; what drew it before must not go on drawing.
const drawnBefore = new Map();

export function render({ model, el }) {
  drawnBefore.get(model.id)?.remove();
  Object.assign(el.style, { position: "relative", width: "100%", height: "100%" });
  const scene = new SceneView(model, el);
  drawnBefore.set(model.id, scene);
  window.markermendScene = debugging(scene);
}
