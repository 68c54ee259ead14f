"use strict";
// Draws boxes, ellipsoids, cylinders, capsules and triangles with WebGL: no library, no textures.
// makeView(canvas, data) gives { draw(time), fit(), turn(), zoom(), shift(), follow() } or null
// where there is no WebGL.
const replay = {};
(function () {
  const decode = (text) => {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    return Int16Array.from({ length: bytes.length >> 1 }, (_, i) => view.getInt16(2 * i, true));
  };

  // Where bodies are at a time: positions between frames are interpolated, and so are turns.
  replay.makeMotion = (data) => {
    const packed = decode(data.poses);
    const frames = data.times.length;
    const read = (body, frame) => {
      if (body.fixed) return body.fixed;
      const at = (body.place * frames + frame) * 7;
      const pose = [];
      for (let i = 0; i < 3; i++) pose.push(body.low[i] + (packed[at + i] + 32768) * body.step);
      for (let i = 3; i < 7; i++) pose.push(packed[at + i] / 32767);
      return pose;
    };
    const frameAt = (time) => {
      let low = 0, high = frames - 1;
      while (low < high) {
        const middle = (low + high + 1) >> 1;
        if (data.times[middle] <= time) low = middle; else high = middle - 1;
      }
      return low;
    };
    const pose = (index, time) => {
      const body = data.bodies[index];
      if (body.fixed) return body.fixed;
      const frame = frameAt(time), next = Math.min(frame + 1, frames - 1);
      const a = read(body, frame), b = read(body, next);
      const span = data.times[next] - data.times[frame];
      const part = span > 0 ? Math.min(Math.max((time - data.times[frame]) / span, 0), 1) : 0;
      const same = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6] < 0 ? -1 : 1;
      const mixed = a.map((v, i) => v + part * ((i < 3 ? b[i] : same * b[i]) - v));
      const length = Math.hypot(mixed[3], mixed[4], mixed[5], mixed[6]) || 1;
      for (let i = 3; i < 7; i++) mixed[i] /= length;
      return mixed;
    };
    return { pose, frames };
  };

  // Matrices are in columns, as WebGL has them.
  const ofPose = ([x, y, z, w, i, j, k]) => [
    1 - 2 * (j * j + k * k), 2 * (i * j + w * k), 2 * (i * k - w * j), 0,
    2 * (i * j - w * k), 1 - 2 * (i * i + k * k), 2 * (j * k + w * i), 0,
    2 * (i * k + w * j), 2 * (j * k - w * i), 1 - 2 * (i * i + j * j), 0,
    x, y, z, 1,
  ];
  const times = (a, b) => {
    const c = new Array(16).fill(0);
    for (let col = 0; col < 4; col++)
      for (let row = 0; row < 4; row++)
        for (let k = 0; k < 4; k++) c[4 * col + row] += a[4 * k + row] * b[4 * col + k];
    return c;
  };
  const IDENTITY = ofPose([0, 0, 0, 1, 0, 0, 0]);
  const LIGHT = [0.35, -0.45, 0.82];

  // Triangles of each form: position and normal of each corner.
  const SECTORS = 28;
  const surface = (rows, columns, corner) => {
    const out = [];
    for (let r = 0; r < rows; r++)
      for (let c = 0; c < columns; c++) {
        const quad = [[r, c], [r, c + 1], [r + 1, c + 1], [r, c], [r + 1, c + 1], [r + 1, c]];
        for (const [row, column] of quad) out.push(...corner(row, column));
      }
    return out;
  };
  const round = (profile) => {
    // A profile is a list of [distance from the axis, height, normal outwards, normal upwards].
    return surface(profile.length - 1, SECTORS, (row, column) => {
      const angle = (2 * Math.PI * column) / SECTORS;
      const [out, up, normalOut, normalUp] = profile[row];
      const c = Math.cos(angle), s = Math.sin(angle);
      return [out * c, out * s, up, normalOut * c, normalOut * s, normalUp];
    });
  };
  const arc = (radius, shift, from, to) => {
    const points = [];
    for (let i = 0; i <= 10; i++) {
      const angle = from + ((to - from) * i) / 10;
      const c = Math.cos(angle), s = Math.sin(angle);
      points.push([radius * c, radius * s + shift, c, s]);
    }
    return points;
  };
  const quarter = Math.PI / 2;
  const forms = {
    box: ({ edges: [x, y, z] }) => {
      const out = [];
      for (let axis = 0; axis < 3; axis++)
        for (const side of [-1, 1])
          for (const [u, v] of [[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]]) {
            const corner = [0, 0, 0], normal = [0, 0, 0];
            corner[axis] = side;
            normal[axis] = side;
            corner[(axis + 1) % 3] = u;
            corner[(axis + 2) % 3] = v;
            out.push((corner[0] * x) / 2, (corner[1] * y) / 2, (corner[2] * z) / 2, ...normal);
          }
      return out;
    },
    ellipsoid: ({ radii: [x, y, z] }) => {
      const unit = round(arc(1, 0, -quarter, quarter));
      for (let i = 0; i < unit.length; i += 6) {
        const normal = [unit[i] / x, unit[i + 1] / y, unit[i + 2] / z];
        const length = Math.hypot(...normal) || 1;
        unit[i] *= x;
        unit[i + 1] *= y;
        unit[i + 2] *= z;
        for (let k = 0; k < 3; k++) unit[i + 3 + k] = normal[k] / length;
      }
      return unit;
    },
    cylinder: ({ radius: r, length }) => {
      const h = length / 2;
      return [
        ...round([[0, -h, 0, -1], [r, -h, 0, -1]]),
        ...round([[r, -h, 1, 0], [r, h, 1, 0]]),
        ...round([[r, h, 0, 1], [0, h, 0, 1]]),
      ];
    },
    capsule: ({ radius, length }) =>
      round([...arc(radius, -length / 2, -quarter, 0), ...arc(radius, length / 2, 0, quarter)]),
    triangles: ({ points, corners }) => {
      const out = [];
      for (const at of corners) {
        const [a, b, c] = at.map((i) => points[i]);
        const u = b.map((v, i) => v - a[i]), v = c.map((w, i) => w - a[i]);
        const normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        const length = Math.hypot(...normal) || 1;
        for (const point of [a, b, c]) out.push(...point, ...normal.map((w) => w / length));
      }
      return out;
    },
  };

  const VERTEX = `
    attribute vec3 corner; attribute vec3 outwards;
    uniform mat4 camera; uniform mat4 place; varying vec3 normal;
    void main() { normal = mat3(place) * outwards; gl_Position = camera * place * vec4(corner, 1.0); }`;
  const FRAGMENT = `
    precision mediump float;
    uniform vec4 colour; uniform float lit; uniform vec3 light; varying vec3 normal;
    void main() {
      vec3 n = normalize(normal);
      float bright = 0.62 + 0.13 * n.z + 0.36 * max(dot(n, light), 0.0);
      gl_FragColor = vec4(mix(colour.rgb, colour.rgb * bright, lit), colour.a);
    }`;

  const program = (gl) => {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(made, shader);
    }
    gl.bindAttribLocation(made, 0, "corner");
    gl.bindAttribLocation(made, 1, "outwards");
    gl.linkProgram(made);
    return gl.getProgramParameter(made, gl.LINK_STATUS) ? made : null;
  };

  // The box around all that moves, over the whole time.
  const extent = (data, motion) => {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const take = (point, margin) => {
      for (let i = 0; i < 3; i++) {
        low[i] = Math.min(low[i], point[i] - margin);
        high[i] = Math.max(high[i], point[i] + margin);
      }
    };
    const step = Math.max(1, Math.floor(data.times.length / 60));
    for (const shape of data.shapes) {
      if (shape.body === null) continue;
      // What rolls away would make all else small.
      const last = shape.role === "object" ? 1 : data.times.length;
      for (let frame = 0; frame < last; frame += step)
        take(motion.pose(shape.body, data.times[frame]), 0.1);
    }
    return low[0] <= high[0] ? { low, high } : { low: [-1, -1, 0], high: [1, 1, 1] };
  };

  replay.makeView = (canvas, data, motion, colours) => {
    const gl = canvas.getContext("webgl", { antialias: true, stencil: true, alpha: false });
    const shader = gl && program(gl);
    if (!shader) return null;
    const uniform = {};
    for (const name of ["camera", "place", "colour", "lit", "light"]) uniform[name] = gl.getUniformLocation(shader, name);
    const numbers = [], parts = [];
    const add = (soup) => {
      const part = { first: numbers.length / 6, count: soup.length / 6 };
      for (const number of soup) numbers.push(number);
      return part;
    };
    for (const shape of data.shapes)
      if (forms[shape.form.kind]) parts.push({ shape, ...add(forms[shape.form.kind](shape.form)) });
    const box = extent(data, motion);
    const around = box.low.map((v, i) => (v + box.high[i]) / 2);
    const size = Math.max(Math.hypot(...box.low.map((v, i) => box.high[i] - v)) / 2, 0.5);
    const reach = Math.max(4, Math.ceil(size * 2.5));
    const pitch = reach > 24 ? 2 : reach > 10 ? 1 : 0.5;
    const cx = Math.round(around[0] / pitch) * pitch, cy = Math.round(around[1] / pitch) * pitch;
    const plane = add([[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]]
      .flatMap(([u, v]) => [cx + u * reach, cy + v * reach, 0, 0, 0, 1]));
    const lines = [];
    for (let at = -reach; at <= reach + 1e-9; at += pitch)
      lines.push(cx + at, cy - reach, 0, 0, 0, 1, cx + at, cy + reach, 0, 0, 0, 1,
        cx - reach, cy + at, 0, 0, 0, 1, cx + reach, cy + at, 0, 0, 0, 1);
    const grid = add(lines);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.STATIC_DRAW);

    const hasGround = data.shapes.some((shape) => shape.form.kind === "ground");
    const view = { azimuth: -0.9, elevation: 0.38, distance: 1, target: around.slice(), followed: null };
    const FIELD = 0.7;
    view.fit = () => {
      view.azimuth = -0.9;
      view.elevation = 0.38;
      view.target = around.slice();
      const narrow = Math.min(1, canvas.clientWidth / Math.max(canvas.clientHeight, 1));
      view.distance = (0.8 * size) / Math.sin(FIELD / 2) / Math.max(narrow, 0.3);
    };
    view.turn = (right, up) => {
      view.azimuth -= right;
      view.elevation = Math.min(Math.max(view.elevation + up, -0.2), 1.55);
    };
    view.zoom = (factor) => {
      view.distance = Math.min(Math.max(view.distance * factor, 0.15), 40 * size);
    };
    view.shift = (right, up) => {
      const s = Math.sin(view.azimuth), c = Math.cos(view.azimuth), e = Math.sin(view.elevation);
      const far = view.distance;
      view.target[0] += far * (-s * right - c * e * up);
      view.target[1] += far * (c * right - s * e * up);
      view.target[2] += far * Math.cos(view.elevation) * up;
    };
    const eyeOf = (target) => {
      const flat = Math.cos(view.elevation) * view.distance;
      return [target[0] + flat * Math.cos(view.azimuth), target[1] + flat * Math.sin(view.azimuth),
        target[2] + view.distance * Math.sin(view.elevation)];
    };
    const camera = (target) => {
      const eye = eyeOf(target);
      const back = eye.map((v, i) => (v - target[i]) / view.distance);
      const right = [-Math.sin(view.azimuth), Math.cos(view.azimuth), 0];
      const up = [back[1] * right[2] - back[2] * right[1], back[2] * right[0] - back[0] * right[2],
        back[0] * right[1] - back[1] * right[0]];
      const along = (v) => -(v[0] * eye[0] + v[1] * eye[1] + v[2] * eye[2]);
      const look = [right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
        along(right), along(up), along(back), 1];
      const near = view.distance / 60, far = view.distance + 12 * size + 2 * reach;
      const f = 1 / Math.tan(FIELD / 2), aspect = canvas.width / Math.max(canvas.height, 1);
      const lens = [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1,
        0, 0, (2 * far * near) / (near - far), 0];
      return times(lens, look);
    };
    // Everything pressed flat onto the ground, along the light.
    const flat = [1, 0, 0, 0, 0, 1, 0, 0, -LIGHT[0] / LIGHT[2], -LIGHT[1] / LIGHT[2], 0, 0, 0, 0, 0.002, 1];

    const set = (place, colour, lit) => {
      gl.uniformMatrix4fv(uniform.place, false, place);
      gl.uniform4fv(uniform.colour, colour);
      gl.uniform1f(uniform.lit, lit);
    };
    const ground = (palette) => {
      gl.enable(gl.POLYGON_OFFSET_FILL);
      gl.polygonOffset(1, 2);
      set(IDENTITY, palette.ground, 0);
      gl.drawArrays(gl.TRIANGLES, plane.first, plane.count);
      gl.disable(gl.POLYGON_OFFSET_FILL);
      set(IDENTITY, palette.line, 0);
      gl.drawArrays(gl.LINES, grid.first, grid.count);
    };
    const shadows = (places, palette) => {
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
      gl.enable(gl.STENCIL_TEST);
      gl.stencilFunc(gl.EQUAL, 0, 255);
      gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
      gl.depthMask(false);
      parts.forEach((part, i) => {
        if (part.shape.role === "surroundings" && part.shape.form.kind === "box") return;
        set(times(flat, places[i]), palette.shadow, 0);
        gl.drawArrays(gl.TRIANGLES, part.first, part.count);
      });
      gl.depthMask(true);
      gl.disable(gl.STENCIL_TEST);
      gl.disable(gl.BLEND);
    };

    view.draw = (time) => {
      const scale = Math.min(window.devicePixelRatio || 1, 2);
      const [w, h] = [Math.round(canvas.clientWidth * scale), Math.round(canvas.clientHeight * scale)];
      if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
      const palette = colours();
      gl.viewport(0, 0, w, h);
      gl.clearColor(...palette.paper);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      gl.useProgram(shader);
      for (const [place, offset] of [[0, 0], [1, 12]]) {
        gl.enableVertexAttribArray(place);
        gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 24, offset);
      }
      const target = view.target.slice();
      if (view.followed !== null) {
        const now = motion.pose(view.followed, time), first = motion.pose(view.followed, data.times[0]);
        for (let i = 0; i < 3; i++) target[i] += now[i] - first[i];
      }
      gl.uniformMatrix4fv(uniform.camera, false, camera(target));
      gl.uniform3fv(uniform.light, LIGHT);
      const places = parts.map(({ shape }) => {
        const own = ofPose(shape.pose);
        return shape.body === null ? own : times(ofPose(motion.pose(shape.body, time)), own);
      });
      if (hasGround) {
        ground(palette);
        shadows(places, palette);
      }
      const paint = (part, place, opacity) => {
        const colour = palette[part.shape.role];
        // Neighbouring links are told apart by a shade.
        const shade = part.shape.body !== null && part.shape.body % 2 ? 0.9 : 1;
        set(place, [colour[0] * shade, colour[1] * shade, colour[2] * shade, opacity], 1);
        gl.drawArrays(gl.TRIANGLES, part.first, part.count);
      };
      const isAround = (part) => part.shape.role === "surroundings";
      parts.forEach((part, i) => isAround(part) || paint(part, places[i], 1));
      // Walls must not hide what happens behind them.
      gl.enable(gl.BLEND);
      gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
      gl.depthMask(false);
      parts.forEach((part, i) => isAround(part) && paint(part, places[i], 0.4));
      gl.depthMask(true);
      gl.disable(gl.BLEND);
    };
    view.fit();
    return view;
  };
})();
