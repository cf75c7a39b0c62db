import { css, mix } from "./scene_colour.js";

// Draws the same picture on a plain canvas, where WebGL is missing.
export class CanvasPainter {
  constructor(host) {
    this.name = "canvas";
    this.canvas = document.createElement("canvas");
    this.canvas.style.cssText = "width:100%;height:100%;display:block";
    host.append(this.canvas);
    this.pen = this.canvas.getContext("2d");
  }

  setScene(meshes, take) {
    this.take = take;
    this.floorPoints = new Float32Array(meshes.floor.points);
    this.floorLines = new Uint32Array(meshes.floor.lines);
    this.floorFade = new Uint8Array(meshes.floor.fade);
    this.floorScreen = new Float32Array(this.floorPoints.length);
  }

  resize(width, height, ratio) {
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    this.ratio = ratio;
  }

  paint(picture, camera, colours) {
    const { pen } = this;
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    pen.fillStyle = css(colours.view);
    pen.fillRect(0, 0, camera.width, camera.height);
    this.paintFloor(camera, colours);
    this.paintShadows(picture, camera, colours);
    this.paintBody(picture, camera, colours);
    pen.lineJoin = "round";
    this.paintPath(picture.rawTrail, camera, css(picture.colour ?? colours.ink), 1.2);
    this.paintPath(picture.trail, camera, css(colours.accent), 2);
    this.paintSelected(picture, camera, colours);
    if (picture.ghost) {
      const at = [0, 0, 0];
      camera.project(...picture.ghost, at);
      this.circle(at[0], at[1], Math.max(6, 20 / camera.millimetres(at[2])),
        null, css(picture.colour), 2);
    }
  }

  paintFloor(camera, colours) {
    const { pen, floorPoints: points, floorLines: lines, floorScreen: screen } = this;
    for (let k = 0; k < points.length; k += 3) {
      camera.project(points[k], points[k + 1], points[k + 2], screen, k);
    }
    pen.lineWidth = 1;
    const byFade = new Map();
    for (let k = 0; k < lines.length; k += 3) {
      const [i, j] = [lines[k + 1], lines[k + 2]];
      const fade = (Math.min(this.floorFade[i], this.floorFade[j]) >> 5) / 7;
      if (fade === 0 || screen[3 * i + 2] < 50 || screen[3 * j + 2] < 50) continue;
      if (!byFade.has(fade)) byFade.set(fade, []);
      byFade.get(fade).push(i, j);
    }
    for (const [fade, ends] of byFade) {
      pen.strokeStyle = css(mix(colours.floor, colours.view, fade, []));
      pen.beginPath();
      for (let k = 0; k < ends.length; k += 2) {
        pen.moveTo(screen[3 * ends[k]], screen[3 * ends[k] + 1]);
        pen.lineTo(screen[3 * ends[k + 1]], screen[3 * ends[k + 1] + 1]);
      }
      pen.stroke();
    }
  }

  paintShadows(picture, camera, colours) {
    const { pen } = this;
    const at = [0, 0, 0];
    const flatness = Math.max(0.05, Math.abs(Math.sin(camera.elevation)));
    pen.fillStyle = css(colours.shadow);
    for (let i = 0; i < picture.n; i++) {
      if (!picture.seen[i]) continue;
      camera.project(picture.xyz[3 * i], picture.xyz[3 * i + 1], this.take.floor, at);
      const radius = (1.7 * picture.radius(i, camera)) / camera.millimetres(at[2]);
      pen.beginPath();
      pen.ellipse(at[0], at[1], radius, radius * flatness, 0, 0, 7);
      pen.fill();
    }
  }

  // Bones and markers from the far side to the near one.
  paintBody(picture, camera, colours) {
    const { screen, seen, fade } = picture;
    const { bones } = this.take;
    const things = [];
    for (let b = 0; b < bones.length; b += 2) {
      const [i, j] = [bones[b], bones[b + 1]];
      if (seen[i] && seen[j]) things.push([(screen[3 * i + 2] + screen[3 * j + 2]) / 2, i, j]);
    }
    for (let i = 0; i < picture.n; i++) {
      if (seen[i] && i !== picture.selected) things.push([screen[3 * i + 2] - 20, i, -1]);
    }
    things.sort((a, b) => b[0] - a[0]);
    for (const [depth, i, j] of things) {
      if (j < 0) this.paintMarker(picture, camera, colours, i);
      else this.paintBone(picture, camera, colours, depth, i, j, (fade[i] + fade[j]) / 2);
    }
  }

  paintBone({ screen, boneRadius }, camera, colours, depth, i, j, fade) {
    const { pen } = this;
    pen.strokeStyle = css(mix(colours.bone, colours.view, fade, []));
    pen.lineWidth = (2 * boneRadius(depth, camera)) / camera.millimetres(depth);
    pen.lineCap = "round";
    pen.beginPath();
    pen.moveTo(screen[3 * i], screen[3 * i + 1]);
    pen.lineTo(screen[3 * j], screen[3 * j + 1]);
    pen.stroke();
  }

  paintMarker(picture, camera, colours, i) {
    const [x, y, depth] = picture.screen.subarray(3 * i, 3 * i + 3);
    const radius = picture.radius(i, camera) / camera.millimetres(depth);
    this.circle(x, y, radius, css(mix(colours.marker, colours.view, picture.fade[i], [])));
    if (picture.neighbours.includes(i)) this.circle(x, y, radius + 2.8, null, css(colours.ink), 1.4);
  }

  paintSelected(picture, camera, colours) {
    const i = picture.selected;
    if (i < 0 || !picture.seen[i]) return;
    const [x, y, depth] = picture.screen.subarray(3 * i, 3 * i + 3);
    const radius = picture.radius(i, camera) / camera.millimetres(depth);
    this.circle(x, y, radius, css(colours.accent), css(picture.outline(colours)), 2);
  }

  paintPath(path, camera, colour, width) {
    const { pen } = this;
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.beginPath();
    const at = [0, 0, 0];
    let down = false;
    for (let k = 0; k < path.length; k += 3) {
      if (path[k] !== path[k]) {
        down = false;
        continue;
      }
      camera.project(path[k], path[k + 1], path[k + 2], at);
      if (down) pen.lineTo(at[0], at[1]);
      else pen.moveTo(at[0], at[1]);
      down = true;
    }
    pen.stroke();
  }

  circle(x, y, radius, fill, stroke, width = 1) {
    const { pen } = this;
    pen.beginPath();
    pen.arc(x, y, radius, 0, 7);
    if (fill) {
      pen.fillStyle = fill;
      pen.fill();
    }
    if (stroke) {
      pen.strokeStyle = stroke;
      pen.lineWidth = width;
      pen.stroke();
    }
  }

  colourAt(x, y, ratio) {
    const { data } = this.pen.getImageData(Math.round(x * ratio), Math.round(y * ratio), 1, 1);
    return [...data.slice(0, 3)];
  }

  dispose() {
    this.canvas.remove();
  }
}
