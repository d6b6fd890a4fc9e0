// The picture that turns: draws what is in the element "data" with WebGL 2, without any library and without any request.
"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const bytes = Uint8Array.from(atob(data.blob), (letter) => letter.charCodeAt(0)).buffer;
const part = (place, Kind) => new Kind(bytes, place[0], place[1]);
const lines = part(data.lines, Uint32Array);
const SIDES = 20;

// One state: places, two axes of the section, radii, and the values of each field on every line.
function stateOf(number) {
  const state = data.states[number];
  const count = data.points;
  const raw = part(state.places, Int16Array);
  const places = new Float32Array(3 * count);
  for (let i = 0; i < 3 * count; i++) places[i] = (raw[i] / 32767) * data.reach;
  const radii = Float32Array.from(part(state.radii, Uint16Array), (value) => (value / 65535) * data.thickest);
  return { places, radii, second: part(state.second, Int8Array), third: part(state.third, Int8Array), state };
}

function valuesOf(state, field) {
  const place = state.values[field.key];
  return Float32Array.from(part(place, Int16Array), (value) => (value / 32767) * field.reach);
}

// Triangles, grown by pieces.
class Surface {
  constructor() {
    this.points = [];
    this.normals = [];
    this.colours = [];
    this.triangles = [];
  }
  vertex(point, normal, colour) {
    this.points.push(point[0], point[1], point[2]);
    this.normals.push(normal[0], normal[1], normal[2]);
    this.colours.push(colour[0], colour[1], colour[2]);
    return this.points.length / 3 - 1;
  }
  strip(first, second) {
    const count = first.length;
    for (let i = 0; i < count; i++) {
      const next = (i + 1) % count;
      this.triangles.push(first[i], first[next], second[next], first[i], second[next], second[i]);
    }
  }
  fan(centre, ring) {
    for (let i = 0; i < ring.length; i++) this.triangles.push(centre, ring[i], ring[(i + 1) % ring.length]);
  }
  // A ring of vertices about a place; the normals lean along the axis by `lean`.
  ring(place, a, b, radius, colour, normal) {
    const found = [];
    for (let side = 0; side < SIDES; side++) {
      const angle = (2 * Math.PI * side) / SIDES;
      const out = combine(a, Math.cos(angle), b, Math.sin(angle));
      found.push(this.vertex(add(place, out, radius), normal || out, colour));
    }
    return found;
  }
  disc(place, a, b, radius, colour, normal) {
    this.fan(this.vertex(place, normal, colour), this.ring(place, a, b, radius, colour, normal));
  }
  // A round piece between two places, or a cone where the radii differ.
  piece(start, end, from, to, colour) {
    const along = unit(add(end, start, -1));
    const [a, b] = across(along);
    this.strip(this.ring(start, a, b, from, colour), this.ring(end, a, b, to, colour));
    this.disc(start, a, b, from, colour, scaled(along, -1));
    this.disc(end, a, b, to, colour, along);
  }
  ball(place, radius, colour) {
    let before = null;
    for (let row = 0; row <= 10; row++) {
      const rise = Math.PI * (row / 10 - 0.5);
      const now = [];
      for (let side = 0; side < SIDES; side++) {
        const turn = (2 * Math.PI * side) / SIDES;
        const out = [Math.cos(rise) * Math.cos(turn), Math.cos(rise) * Math.sin(turn), Math.sin(rise)];
        now.push(this.vertex(add(place, out, radius), out, colour));
      }
      if (before) this.strip(before, now);
      before = now;
    }
  }
}

const add = (a, b, s) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const scaled = (a, s) => [s * a[0], s * a[1], s * a[2]];
const combine = (a, s, b, t) => [s * a[0] + t * b[0], s * a[1] + t * b[1], s * a[2] + t * b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => scaled(a, 1 / (Math.hypot(...a) || 1));
const at = (array, place) => [array[3 * place], array[3 * place + 1], array[3 * place + 2]];
function across(along) {
  const least = along.map(Math.abs);
  const axis = [0, 0, 0];
  axis[least.indexOf(Math.min(...least))] = 1;
  const a = unit(cross(along, axis));
  return [a, cross(along, a)];
}

// Colours of a field: piecewise linear between stops.
function colourOf(field, value) {
  const stops = field.stops;
  const share = field.high === field.low ? 0.5 : (value - field.low) / (field.high - field.low);
  const place = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const low = Math.min(Math.floor(place), stops.length - 2);
  return stops[low].map((channel, i) => (channel + (place - low) * (stops[low + 1][i] - channel)) / 255);
}

function build(shape, field, plain) {
  const surface = new Surface();
  const values = field ? valuesOf(shape.state, field) : null;
  // The value at a point is the mean of the lines that meet there.
  const sums = new Float32Array(data.points);
  const meet = new Uint8Array(data.points);
  for (let line = 0; line < lines.length / 2; line++)
    for (const point of [lines[2 * line], lines[2 * line + 1]]) {
      meet[point] += 1;
      if (values) sums[point] += values[line];
    }
  const colour = (point) => plain || colourOf(field, sums[point] / (meet[point] || 1));
  for (let line = 0; line < lines.length / 2; line++) {
    const rings = [0, 1].map((end) => {
      const point = lines[2 * line + end];
      const [a, b] = [unit(at(shape.second, point)), unit(at(shape.third, point))];
      const place = at(shape.places, point);
      const radius = Math.max(shape.radii[point], data.thinnest);
      if (meet[point] === 1) surface.disc(place, a, b, radius, colour(point), scaled(cross(a, b), end ? 1 : -1));
      return surface.ring(place, a, b, radius, colour(point));
    });
    surface.strip(rings[0], rings[1]);
  }
  for (const [node, radius, touching] of data.balls) {
    const mean = touching.reduce((sum, point) => sum + sums[point] / (meet[point] || 1), 0) / (touching.length || 1);
    surface.ball(at(shape.places, node), radius, plain || (touching.length ? colourOf(field, mean) : data.grey));
  }
  for (const [start, end, radius] of data.bars)
    surface.piece(at(shape.places, start), at(shape.places, end), radius, radius, plain || data.body);
  if (plain) return surface;
  for (const [kind, node, axis, shift, size] of shape.state.supports) {
    const place = add(at(shape.places, node), axis, shift);
    if (kind === "cone") {
      surface.piece(place, add(place, axis, 1.9 * size), 0.35 * size, 1.2 * size, data.ground);
      surface.piece(add(place, axis, 1.9 * size), add(place, axis, 2.2 * size), 1.6 * size, 1.6 * size, data.ground);
    } else if (kind === "bar") {
      surface.piece(add(place, axis, -2.2 * size), add(place, axis, 2.2 * size), 0.35 * size, 0.35 * size, data.ground);
    } else surface.piece(place, add(place, axis, 0.5 * size), 1.8 * size, 1.8 * size, data.ground);
  }
  for (const [kind, tail, tip] of shape.state.arrows) {
    const along = unit(add(tip, tail, -1));
    const paint = data.arrow[kind];
    const head = add(tip, along, -0.045 * data.size);
    surface.piece(tail, head, 0.006 * data.size, 0.006 * data.size, paint);
    surface.piece(head, tip, 0.016 * data.size, 0, paint);
    if (kind.endsWith("moment")) surface.piece(add(head, along, -0.04 * data.size), head, 0.016 * data.size, 0, paint);
  }
  return surface;
}

// The drawing itself.
const canvas = document.getElementById("picture");
const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
const control = (name) => document.getElementById(name);

function start() {
  const program = gl.createProgram();
  const sources = [
    [gl.VERTEX_SHADER, `#version 300 es
      in vec3 point, normal, colour; uniform mat3 turn; uniform vec3 middle; uniform vec2 zoom; uniform vec2 shift; uniform float depth;
      out vec3 n, c;
      void main() { vec3 p = turn * (point - middle); n = turn * normal; c = colour;
        gl_Position = vec4((p.xy + shift) * zoom, -p.z * depth, 1.0); }`],
    [gl.FRAGMENT_SHADER, `#version 300 es
      precision highp float; in vec3 n, c; uniform float opacity; out vec4 colour;
      void main() { vec3 m = normalize(gl_FrontFacing ? n : -n);
        float light = 0.42 + 0.5 * max(dot(m, normalize(vec3(-0.3, 0.9, 1.2))), 0.0) + 0.16 * max(dot(m, normalize(vec3(0.6, -0.5, 0.7))), 0.0);
        colour = vec4(c * light, opacity); }`],
  ];
  for (const [kind, source] of sources) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  gl.useProgram(program);
  const place = (name) => gl.getUniformLocation(program, name);
  const meshes = { now: null, ghost: null };

  function load(name, surface) {
    const mesh = meshes[name] || { array: gl.createVertexArray(), buffers: [0, 1, 2, 3].map(() => gl.createBuffer()) };
    gl.bindVertexArray(mesh.array);
    [["point", surface.points], ["normal", surface.normals], ["colour", surface.colours]].forEach(([attribute, array], i) => {
      gl.bindBuffer(gl.ARRAY_BUFFER, mesh.buffers[i]);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(array), gl.DYNAMIC_DRAW);
      const index = gl.getAttribLocation(program, attribute);
      gl.enableVertexAttribArray(index);
      gl.vertexAttribPointer(index, 3, gl.FLOAT, false, 0, 0);
    });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, mesh.buffers[3]);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(surface.triangles), gl.DYNAMIC_DRAW);
    mesh.count = surface.triangles.length;
    meshes[name] = mesh;
  }

  // Where the reader stands: azimuth and elevation in radians, zoom, and a shift in the plane of the screen.
  const home = { turn: data.view[0], rise: data.view[1], zoom: 1, shift: [0, 0] };
  // So large that the unloaded and the last state fill the picture.
  function fit() {
    const [right, up] = axes();
    const box = [Infinity, -Infinity, Infinity, -Infinity];
    for (const number of [0, data.states.length - 1]) {
      const { places, radii } = stateOf(number);
      for (let point = 0; point < data.points; point++) {
        const [x, y] = [dot(at(places, point), right), dot(at(places, point), up)];
        const r = radii[point] + 0.06 * data.size;
        box[0] = Math.min(box[0], x - r);
        box[1] = Math.max(box[1], x + r);
        box[2] = Math.min(box[2], y - r);
        box[3] = Math.max(box[3], y + r);
      }
    }
    const least = Math.min(canvas.clientWidth, canvas.clientHeight);
    const scale = Math.min(canvas.clientWidth / (box[1] - box[0]), canvas.clientHeight / (box[3] - box[2]));
    home.zoom = (scale * data.size) / (0.95 * least);
    home.shift = [-(box[0] + box[1]) / 2, -(box[2] + box[3]) / 2];
    view = { ...home };
  }
  let view = { ...home };
  const axes = () => {
    const [t, r] = [view.turn, view.rise];
    const towards = [Math.cos(r) * Math.cos(t), Math.cos(r) * Math.sin(t), Math.sin(r)];
    const right = [-Math.sin(t), Math.cos(t), 0];
    return [right, cross(towards, right), towards];
  };
  let shape = null;
  let pending = false;

  function draw() {
    pending = false;
    const [wide, high] = [canvas.clientWidth, canvas.clientHeight];
    const sharp = window.devicePixelRatio || 1;
    canvas.width = wide * sharp;
    canvas.height = high * sharp;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.enable(gl.DEPTH_TEST);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const frame = axes();
    // Columns of the matrix are what the axes of the network become.
    gl.uniformMatrix3fv(place("turn"), false, [0, 1, 2].flatMap((axis) => frame.map((row) => row[axis])));
    gl.uniform3fv(place("middle"), data.middle);
    const unitary = (1.9 * view.zoom) / data.size;
    gl.uniform2f(place("zoom"), unitary * Math.min(1, high / wide), unitary * Math.min(1, wide / high));
    gl.uniform2fv(place("shift"), view.shift);
    gl.uniform1f(place("depth"), 0.5 / data.size);
    const paint = (mesh, opacity) => {
      gl.uniform1f(place("opacity"), opacity);
      gl.bindVertexArray(mesh.array);
      gl.drawElements(gl.TRIANGLES, mesh.count, gl.UNSIGNED_INT, 0);
    };
    paint(meshes.now, 1);
    if (control("ghost").checked) {
      gl.enable(gl.BLEND);
      gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      gl.colorMask(false, false, false, false);
      paint(meshes.ghost, 1);
      gl.colorMask(true, true, true, true);
      gl.depthFunc(gl.LEQUAL);
      paint(meshes.ghost, 0.28);
      gl.depthFunc(gl.LESS);
      gl.disable(gl.BLEND);
    }
  }
  const redraw = () => {
    if (!pending) requestAnimationFrame(draw);
    pending = true;
  };

  const screen = (point) => {
    const [right, up, towards] = axes();
    const away = add(point, data.middle, -1);
    const scale = (0.95 * view.zoom * Math.min(canvas.clientWidth, canvas.clientHeight)) / data.size;
    return [
      canvas.clientWidth / 2 + scale * (dot(away, right) + view.shift[0]),
      canvas.clientHeight / 2 - scale * (dot(away, up) + view.shift[1]),
      dot(away, towards),
    ];
  };

  function show() {
    const field = data.fields[control("field").selectedIndex];
    shape = stateOf(Number(control("state").value));
    load("now", build(shape, field, null));
    control("where").textContent = shape.state.label;
    control("legend").innerHTML = field.legend;
    redraw();
  }
  load("ghost", build(stateOf(0), null, data.pale));

  // What the pointer does.
  const held = new Map();
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    held.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointerup", (event) => held.delete(event.pointerId));
  canvas.addEventListener("pointercancel", (event) => held.delete(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    const before = held.get(event.pointerId);
    if (!before) return hover(event);
    const [dx, dy] = [event.clientX - before[0], event.clientY - before[1]];
    if (held.size > 1) {
      const other = [...held.entries()].find(([id]) => id !== event.pointerId)[1];
      const far = (a) => Math.hypot(a[0] - other[0], a[1] - other[1]) || 1;
      view.zoom *= far([event.clientX, event.clientY]) / far(before);
    } else if (event.shiftKey || event.buttons === 2) {
      const scale = data.size / (0.95 * view.zoom * Math.min(canvas.clientWidth, canvas.clientHeight));
      view.shift = [view.shift[0] + dx * scale, view.shift[1] - dy * scale];
    } else {
      view.turn -= dx * 0.008;
      view.rise = Math.min(Math.max(view.rise + dy * 0.008, -Math.PI / 2), Math.PI / 2);
    }
    held.set(event.pointerId, [event.clientX, event.clientY]);
    redraw();
  });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("dblclick", () => {
    view = { ...home };
    redraw();
  });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    view.zoom *= Math.exp(-0.0015 * event.deltaY);
    redraw();
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
    if (!step) return;
    event.preventDefault();
    view.turn += step[0];
    view.rise = Math.min(Math.max(view.rise + step[1], -Math.PI / 2), Math.PI / 2);
    redraw();
  });

  // The name and the value of what is under the pointer.
  function hover(event) {
    const box = canvas.getBoundingClientRect();
    const mouse = [event.clientX - box.left, event.clientY - box.top];
    let best = null;
    const offer = (point, text, reach) => {
      const seen = screen(point);
      const far = Math.hypot(seen[0] - mouse[0], seen[1] - mouse[1]);
      if (far < reach && (!best || far - 0.01 * seen[2] < best.far)) best = { far: far - 0.01 * seen[2], text };
    };
    const field = data.fields[control("field").selectedIndex];
    const values = valuesOf(shape.state, field);
    const thick = (0.95 * view.zoom * Math.min(canvas.clientWidth, canvas.clientHeight)) / data.size;
    for (let line = 0; line < lines.length / 2; line++) {
      const middle = combine(at(shape.places, lines[2 * line]), 0.5, at(shape.places, lines[2 * line + 1]), 0.5);
      const text = `${data.members[data.member[line]]}: ${field.words} ${format(values[line])} ${field.unit}`;
      offer(middle, text, 4 + thick * shape.radii[lines[2 * line]]);
    }
    data.nodes.forEach((name, node) => offer(at(shape.places, node), `node ${name}`, 9));
    const tip = control("tip");
    tip.hidden = !best;
    if (!best) return;
    tip.textContent = best.text;
    tip.style.left = `${mouse[0] + 14}px`;
    tip.style.top = `${mouse[1] + 10}px`;
  }
  canvas.addEventListener("pointerleave", () => (control("tip").hidden = true));

  let timer = null;
  control("play").addEventListener("click", () => {
    const slider = control("state");
    if (timer) clearInterval(timer);
    if (timer) timer = null;
    else {
      if (slider.value === slider.max) slider.value = 0;
      timer = setInterval(() => {
        slider.value = Number(slider.value) + 1;
        show();
        if (slider.value === slider.max) control("play").click();
      }, 80);
    }
    control("play").textContent = timer ? "Stop" : "Play";
  });
  for (const name of ["state", "field"]) control(name).addEventListener("input", show);
  control("ghost").addEventListener("input", redraw);
  window.addEventListener("resize", redraw);
  fit();
  show();
}

const format = (value) => (value === 0 ? "0" : Number(value.toPrecision(4)).toString().replace("-", "\u2212"));
if (gl) start();
else {
  document.getElementById("view").hidden = true;
  document.getElementById("still").hidden = false;
}
