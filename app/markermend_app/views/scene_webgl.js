import { mix } from "./scene_colour.js";
import { cross } from "./scene_camera.js";

// Draws a picture with vtk.js: unit shapes made by pyvista, put in place once for every frame.
const FLAT = [1, 0, 0, 0, 1, 0, 0, 0, 1];

// Many copies of one shape, each with its place, direction, size and colour.
class Copies {
  constructor(vtk, renderer, shape, capacity) {
    this.points = new Float32Array(3 * capacity);
    this.turns = new Float32Array(9 * capacity);
    this.sizes = new Float32Array(3 * capacity);
    this.colours = new Uint8Array(3 * capacity);
    this.capacity = capacity;
    const array = (name, values, numberOfComponents) =>
      vtk.Common.Core.vtkDataArray.newInstance({ name, values, numberOfComponents });
    this.data = vtk.Common.DataModel.vtkPolyData.newInstance();
    this.data.getPoints().setData(this.points, 3);
    this.arrays = [array("turn", this.turns, 9), array("size", this.sizes, 3)];
    for (const one of this.arrays) this.data.getPointData().addArray(one);
    this.scalars = array("colour", this.colours, 3);
    this.data.getPointData().setScalars(this.scalars);

    this.mapper = vtk.Rendering.Core.vtkGlyph3DMapper.newInstance({
      orientationArray: "turn", scaleArray: "size",
    });
    this.mapper.setOrientationModeToMatrix();
    this.mapper.setScaleModeToScaleByComponents();
    this.mapper.setInputData(this.data, 0);
    this.mapper.setInputData(shape, 1);
    this.actor = vtk.Rendering.Core.vtkActor.newInstance();
    this.actor.setMapper(this.mapper);
    this.actor.getProperty().setLighting(false);
    renderer.addActor(this.actor);
  }

  begin(home) {
    this.used = 0;
    this.home = home;
  }

  add(x, y, z, turn, width, length) {
    const i = this.used++;
    this.points[3 * i] = x;
    this.points[3 * i + 1] = y;
    this.points[3 * i + 2] = z;
    this.turns.set(turn, 9 * i);
    this.sizes[3 * i] = this.sizes[3 * i + 1] = width;
    this.sizes[3 * i + 2] = length;
    return 3 * i; // where its colour goes
  }

  end() {
    for (let i = this.used; i < this.capacity; i++) {
      this.points.set(this.home, 3 * i);
      this.sizes.fill(0, 3 * i, 3 * i + 3);
    }
    this.data.getPoints().modified();
    for (const one of this.arrays) one.modified();
    this.scalars.modified();
    this.data.modified();
  }
}

// A path of separate segments; those with an unseen end shrink to nothing.
class Path {
  constructor(vtk, renderer, mesh, width) {
    this.data = mesh;
    this.points = mesh.getPoints().getData();
    this.mapper = vtk.Rendering.Core.vtkMapper.newInstance({ scalarVisibility: false });
    this.mapper.setInputData(mesh);
    this.actor = vtk.Rendering.Core.vtkActor.newInstance();
    this.actor.setMapper(this.mapper);
    this.actor.getProperty().set({ lighting: false, lineWidth: width });
    renderer.addActor(this.actor);
  }

  set(path, home, colour) {
    let drawn = 0;
    for (let k = 0; k + 3 < path.length; k += 3) {
      const seen = path[k] === path[k] && path[k + 3] === path[k + 3];
      this.points.set(seen ? path.subarray(k, k + 6) : [...home, ...home], 2 * k);
      drawn += seen;
    }
    this.actor.setVisibility(drawn > 0);
    this.actor.getProperty().setColor(...colour.map((c) => c / 255));
    this.data.getPoints().modified();
    this.data.modified();
  }
}

function polydata(vtk, { points, polys, lines }) {
  const data = vtk.Common.DataModel.vtkPolyData.newInstance();
  data.getPoints().setData(new Float32Array(points.slice(0)), 3); // paths write into theirs
  if (polys) data.getPolys().setData(new Uint32Array(polys));
  if (lines) data.getLines().setData(new Uint32Array(lines));
  return data;
}

export class WebGLPainter {
  static available() {
    const context = document.createElement("canvas").getContext("webgl2");
    context?.getExtension("WEBGL_lose_context")?.loseContext(); // browsers allow few at a time
    return context !== null;
  }

  constructor(vtk, host, onLost) {
    this.vtk = vtk;
    this.name = "webgl";
    this.renderer = vtk.Rendering.Core.vtkRenderer.newInstance();
    this.window = vtk.Rendering.Core.vtkRenderWindow.newInstance();
    this.window.addRenderer(this.renderer);
    this.view = vtk.Rendering.OpenGL.vtkRenderWindow.newInstance();
    this.window.addView(this.view);
    this.view.setContainer(host);
    this.canvas = this.view.getCanvas();
    this.canvas.addEventListener("webglcontextlost", onLost, { once: true });
    this.camera = this.renderer.getActiveCamera();
    this.place = [0, 0, 0];
  }

  setScene(meshes, take) {
    const { vtk, renderer } = this;
    renderer.removeAllActors();
    const copies = (shape, capacity) =>
      new Copies(vtk, renderer, polydata(vtk, meshes[shape]), capacity);
    this.floor = this.addFloor(meshes.floor);
    this.discs = copies("disc", Math.max(1, 2 * take.n_markers)); // markers and their shadows
    this.bones = copies("bone", Math.max(1, take.bones.length / 2));
    this.rings = copies("ring", take.n_markers + 2);
    this.paths = [[1, "rawTrail"], [2, "trail"]].map(([width, name]) =>
      [name, new Path(vtk, renderer, polydata(vtk, meshes.trail), width)]);
    this.take = take;
    this.coloured = null;
  }

  addFloor({ fade, ...mesh }) {
    const { vtk } = this;
    const data = polydata(vtk, mesh);
    const colours = new Uint8Array(3 * fade.byteLength);
    const scalars = vtk.Common.Core.vtkDataArray.newInstance({
      name: "colour", values: colours, numberOfComponents: 3,
    });
    data.getPointData().setScalars(scalars);
    const mapper = vtk.Rendering.Core.vtkMapper.newInstance();
    mapper.setInputData(data);
    const actor = vtk.Rendering.Core.vtkActor.newInstance();
    actor.setMapper(mapper);
    actor.getProperty().setLighting(false);
    this.renderer.addActor(actor);
    return { data, scalars, colours, fade: new Uint8Array(fade) };
  }

  colourFloor(colours) {
    const { fade, colours: out, scalars, data } = this.floor;
    for (let i = 0; i < fade.length; i++) mix(colours.floor, colours.view, fade[i] / 255, out, 3 * i);
    scalars.modified();
    data.modified();
    this.renderer.setBackground(...colours.view.map((c) => c / 255));
    this.coloured = colours;
  }

  resize(width, height, ratio) {
    this.view.setSize(Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio)));
  }

  paint(picture, camera, colours) {
    if (this.coloured !== colours) this.colourFloor(colours);
    const home = camera.focal;
    const facing = [...camera.right, ...camera.up, ...camera.back];
    this.paintMarkers(picture, camera, colours, home, facing);
    this.paintBones(picture, camera, colours, home);
    this.paintRings(picture, camera, colours, home, facing);
    for (const [name, path] of this.paths) {
      path.set(picture[name], home, name === "trail" ? colours.accent : picture.colour ?? colours.ink);
    }
    this.camera.setPosition(...camera.position);
    this.camera.setFocalPoint(...camera.focal);
    this.camera.setViewUp(0, 0, 1);
    this.camera.setViewAngle((camera.angle * 180) / Math.PI);
    this.camera.setClippingRange(Math.max(20, camera.distance * 0.05), camera.distance + 40000);
    this.window.render();
  }

  paintMarkers(picture, camera, colours, home, facing) {
    const { discs } = this;
    const { xyz, seen, fade } = picture;
    const { back } = camera;
    discs.begin(home);
    for (let i = 0; i < picture.n; i++) {
      if (!seen[i]) continue;
      const x = xyz[3 * i], y = xyz[3 * i + 1], z = xyz[3 * i + 2];
      const radius = picture.radius(i, camera);
      if (i === picture.selected) {
        const scale = nearer(camera, x, y, z, 0, this.place);
        discs.colours.set(colours.accent, discs.add(...this.place, facing, radius * scale, 1));
      } else {
        // Nearer to the eye by its radius, as the front of a ball is: clear of the bones' ends.
        const at = discs.add(x + radius * back[0], y + radius * back[1], z + radius * back[2],
          facing, radius, 1);
        mix(colours.marker, colours.view, fade[i], discs.colours, at);
      }
      const on = discs.add(x, y, this.take.floor + 1, FLAT, 1.7 * radius, 1);
      discs.colours.set(colours.shadow, on);
    }
    discs.end();
  }

  paintBones(picture, camera, colours, home) {
    const { xyz, seen, fade, screen } = picture;
    const { bones } = this.take;
    this.bones.begin(home);
    for (let b = 0; b < bones.length; b += 2) {
      const [i, j] = [bones[b], bones[b + 1]];
      if (!seen[i] || !seen[j]) continue;
      const from = xyz.subarray(3 * i, 3 * i + 3), to = xyz.subarray(3 * j, 3 * j + 3);
      const length = Math.hypot(to[0] - from[0], to[1] - from[1], to[2] - from[2]);
      if (length < 1) continue;
      const depth = (screen[3 * i + 2] + screen[3 * j + 2]) / 2;
      const width = picture.boneRadius(depth, camera);
      const turn = facingStrip(from, to, length, camera);
      const at = this.bones.add(from[0], from[1], from[2], turn, width, length);
      mix(colours.bone, colours.view, (fade[i] + fade[j]) / 2, this.bones.colours, at);
    }
    this.bones.end();
  }

  paintRings(picture, camera, colours, home, facing) {
    this.rings.begin(home);
    const ring = (x, y, z, radius, colour, layer) => {
      const scale = nearer(camera, x, y, z, layer, this.place);
      const at = this.rings.add(...this.place, facing, radius * scale, 1);
      this.rings.colours.set(colour, at);
    };
    const around = (i, extra, colour, layer) => {
      if (i < 0 || !picture.seen[i]) return;
      const radius = picture.radius(i, camera) + extra * camera.millimetres(picture.screen[3 * i + 2]);
      ring(picture.xyz[3 * i], picture.xyz[3 * i + 1], picture.xyz[3 * i + 2], radius, colour, layer);
    };
    for (const i of picture.neighbours) around(i, 3.5, colours.ink, -1);
    around(picture.selected, 2, picture.outline(colours), 1);
    if (picture.ghost) {
      const depth = picture.seen[picture.selected]
        ? picture.screen[3 * picture.selected + 2] : camera.distance;
      const radius = Math.max(20, 6.5 * camera.millimetres(depth));
      ring(...picture.ghost, radius, picture.colour, 2);
    }
    this.rings.end();
  }

  // Colour really drawn at a point of the screen, for tests: drawn anew, then read back.
  colourAt(x, y, ratio) {
    this.window.render();
    const gl = this.view.get3DContext();
    const out = new Uint8Array(4);
    const height = this.canvas.height;
    gl.readPixels(Math.round(x * ratio), height - 1 - Math.round(y * ratio), 1, 1,
      gl.RGBA, gl.UNSIGNED_BYTE, out);
    return [...out.subarray(0, 3)];
  }

  dispose() {
    this.view.setContainer(null);
    this.view.delete();
    this.window.delete();
  }
}

// A place before the whole body on the ray to the eye, so that what matters is never hidden; higher
// layers lie before lower ones. Returns by how much a thing there has to shrink to look the same.
function nearer(camera, x, y, z, layer, out) {
  const scale = 0.5 - 0.01 * layer;
  const [ex, ey, ez] = camera.position;
  out[0] = ex + (x - ex) * scale;
  out[1] = ey + (y - ey) * scale;
  out[2] = ez + (z - ez) * scale;
  return scale;
}

// Columns of the rotation that turns z along a bone and y to the eye.
function facingStrip(from, to, length, camera) {
  const z = [(to[0] - from[0]) / length, (to[1] - from[1]) / length, (to[2] - from[2]) / length];
  const across = cross(camera.back, z);
  const size = Math.hypot(...across);
  const x = size > 1e-3 ? across.map((c) => c / size) : camera.right; // seen from its end
  return [...x, ...cross(z, x), ...z];
}
