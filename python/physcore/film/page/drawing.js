// Draws the frames of a film by WebGL2, from the arrays of its tracks.
class Drawing {
  constructor(canvas, film, bytes) {
    const gl = canvas.getContext("webgl2", {antialias: true, alpha: false, preserveDrawingBuffer: true});
    if (!gl) throw new Error("no WebGL2");
    Object.assign(this, {gl, canvas, film, turn: STRAIGHT, zoom: [1, 0, 0], programs: {}, buffers: new Map(), pictures: {}});
    this.numbers = gl.getExtension("EXT_color_buffer_float");
    this.fields = this.numbers || gl.getExtension("EXT_color_buffer_half_float");
    for (const kind of Object.keys(PROGRAMS)) this.programs[kind] = this.program(...PROGRAMS[kind]);
    this.tracks = film.tracks.map(track => {
      const streams = Object.fromEntries(Object.entries(track.streams || {}).map(([name, spec]) => [name, new Stream(spec, bytes, track.still ? 1 : film.count)]));
      const fixed = name => track[name] && new Stream(track[name], bytes, 1);
      const even = Object.values(streams).every(stream => stream.even);
      return {...track, streams, fixed, even, id: Symbol(track.kind)};
    });
  }
  program(vertex, fragment) {
    const gl = this.gl, program = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    const uniforms = {}, attributes = {};
    for (let k = 0; k < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); k++) {
      const {name} = gl.getActiveUniform(program, k);
      uniforms[name] = gl.getUniformLocation(program, name);
    }
    for (let k = 0; k < gl.getProgramParameter(program, gl.ACTIVE_ATTRIBUTES); k++) {
      const {name} = gl.getActiveAttrib(program, k);
      attributes[name] = gl.getAttribLocation(program, name);
    }
    return {program, uniforms, attributes};
  }
  // Uploads an array, unless the same one is there already.
  buffer(key, name, data, target = this.gl.ARRAY_BUFFER) {
    const gl = this.gl, own = this.buffers.get(key) || this.buffers.set(key, {}).get(key);
    const entry = own[name] || (own[name] = {buffer: gl.createBuffer(), data: null});
    gl.bindBuffer(target, entry.buffer);
    if (entry.data === null || entry.data.buffer !== data.buffer || entry.data.byteOffset !== data.byteOffset) gl.bufferData(target, data, gl.DYNAMIC_DRAW);
    entry.data = data;
  }
  texture(key, name, at, width, height, data, kind) {
    const gl = this.gl, own = this.buffers.get(key) || this.buffers.set(key, {}).get(key);
    const fresh = !own[name], entry = own[name] || (own[name] = {texture: gl.createTexture(), data: null});
    gl.activeTexture(gl.TEXTURE0 + at);
    gl.bindTexture(gl.TEXTURE_2D, entry.texture);
    if (fresh) {
      const smooth = kind === "values" ? gl.NEAREST : gl.LINEAR;
      for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, smooth);
      for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
    }
    if (entry.data === null || entry.data.buffer !== data.buffer || entry.data.byteOffset !== data.byteOffset) {
      gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
      const [inner, outer] = kind === "color" ? [gl.RGBA8, gl.RGBA] : [gl.R8, gl.RED];
      gl.texImage2D(gl.TEXTURE_2D, 0, inner, width, height, 0, outer, gl.UNSIGNED_BYTE, data);
    }
    entry.data = data;
    gl.uniform1i(this.now.uniforms[name], at);
  }
  // Draws into a picture beside the canvas, smaller by a factor, and returns the function that ends this. Numbers of 32 bits
  // have depths too, and are not smoothed.
  beside(name, factor, format) {
    const gl = this.gl, width = Math.max(1, Math.round(this.canvas.width / factor)), height = Math.max(1, Math.round(this.canvas.height / factor));
    const own = this.pictures[name] || (this.pictures[name] = {texture: gl.createTexture(), frame: gl.createFramebuffer()});
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, own.texture);
    gl.bindFramebuffer(gl.FRAMEBUFFER, own.frame);
    if (own.width !== width || own.height !== height) {
      Object.assign(own, {width, height});
      const type = {[gl.RGBA8]: gl.UNSIGNED_BYTE, [gl.RGBA16F]: gl.HALF_FLOAT, [gl.RGBA32F]: gl.FLOAT}[format];
      gl.texImage2D(gl.TEXTURE_2D, 0, format, width, height, 0, gl.RGBA, type, null);
      for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, format === gl.RGBA32F ? gl.NEAREST : gl.LINEAR);
      for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, own.texture, 0);
      if (format === gl.RGBA32F) {
        gl.bindRenderbuffer(gl.RENDERBUFFER, own.depth || (own.depth = gl.createRenderbuffer()));
        gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT24, width, height);
        gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, own.depth);
      }
    }
    this.wide = width;
    gl.disable(gl.SCISSOR_TEST);
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    return () => {
      this.wide = this.canvas.width;
      gl.bindFramebuffer(gl.FRAMEBUFFER, null);
      gl.enable(gl.SCISSOR_TEST);
      gl.viewport(0, 0, this.canvas.width, this.canvas.height);
      gl.activeTexture(gl.TEXTURE0);
      gl.bindTexture(gl.TEXTURE_2D, own.texture);
      gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    };
  }
  // Draws a picture beside the canvas over the whole canvas.
  over(kind, panel, frame, values, more = () => {}) {
    const gl = this.gl, [width, height] = this.film.size, kept = this.zoom;
    this.zoom = [1, 0, 0];
    this.use(kind, panel, {}, frame, 0);
    this.zoom = kept;
    gl.uniform1i(this.now.uniforms.picture, 0);
    for (const [name, value] of Object.entries(values)) gl.uniform1f(this.now.uniforms[name], value);
    more();
    this.rectangle("over", [[0, 0], [width, 0], [width, height], [0, height]], [[0, 1], [1, 1], [1, 0], [0, 0]]);
    this.finish();
  }
  use(kind, panel, track, frame, share) {
    const gl = this.gl, now = this.now = this.programs[kind], film = this.film, place = film.panels[panel];
    const eyes = film.eyes[panel] || [[1, 0, 0, 0]], deep = Boolean(track.deep);
    gl.useProgram(now.program);
    gl.uniform2f(now.uniforms.size, ...film.size);
    gl.uniform1f(now.uniforms.pixel, this.wide / film.size[0]);
    gl.uniform4f(now.uniforms.eye, ...eyes[Math.min(frame, eyes.length - 1)]);
    gl.uniformMatrix3fv(now.uniforms.turn, false, deep ? this.turn : STRAIGHT);
    gl.uniform3f(now.uniforms.zoom, ...this.zoom);
    gl.uniform1i(now.uniforms.deep, deep);
    gl.uniform1f(now.uniforms.share, share);
    gl.uniform2f(now.uniforms.fog, film.fog, place.reach);
    gl.uniform3f(now.uniforms.background, ...film.background.map(each => each / 255));
    gl.uniform4f(now.uniforms.plane, ...this.plane);
    gl.uniform3f(now.uniforms.low, 0, 0, 0);
    gl.uniform3f(now.uniforms.span, 1, 1, 1);
  }
  // The sky that water reflects; none without one.
  sky(sky) {
    const gl = this.gl, {uniforms} = this.now, [horizon, zenith, high, [brightness]] = sky || [[0, 0, 0], [0, 0, 0], [0, 0, 1], [0]];
    gl.uniform3f(uniforms.horizon, ...horizon.map(each => each / 255));
    gl.uniform3f(uniforms.zenith, ...zenith.map(each => each / 255));
    gl.uniform3f(uniforms.high, ...apply(this.turn, high));
    gl.uniform1f(uniforms.brightness, brightness);
  }
  // Points an attribute at some columns of an array.
  attribute(name, key, label, data, columns, from, count, divisor) {
    const gl = this.gl, location = this.now.attributes[name];
    if (location === undefined) return;
    this.buffer(key, label, data);
    const type = {2: gl.UNSIGNED_SHORT, 1: gl.UNSIGNED_BYTE, 4: gl.FLOAT}[data.BYTES_PER_ELEMENT];
    gl.enableVertexAttribArray(location);
    gl.vertexAttribPointer(location, count, type, type !== gl.FLOAT, columns * data.BYTES_PER_ELEMENT, from * data.BYTES_PER_ELEMENT);
    gl.vertexAttribDivisor(location, divisor);
  }
  // The quantized places of two frames.
  places(track, frame, share, pairs, divisor, columns) {
    const gl = this.gl, {places} = track.streams, wide = columns || places.columns, count = track.deep ? 3 : 2;
    const later = share > 0 ? places.at(frame + 1) : places.at(frame);
    for (const [one, other, from] of pairs) {
      this.attribute(one, track.id, "one", places.at(frame), wide, from, count, divisor);
      this.attribute(other, track.id, "other", later, wide, from, count, divisor);
    }
    gl.uniform3f(this.now.uniforms.low, places.low[0], places.low[1], places.low[2] || 0);
    gl.uniform3f(this.now.uniforms.span, places.span[0], places.span[1], places.span[2] || 0);
  }
  finish() { for (const location of Object.values(this.now.attributes)) this.gl.disableVertexAttribArray(location); }

  draw(position) {
    const gl = this.gl, film = this.film, ratio = this.canvas.width / film.size[0], height = this.canvas.height;
    const frame = Math.min(Math.floor(position + 1e-6), film.count - 1), share = Math.max(0, frame + 1 < film.count ? position - frame : 0);
    gl.disable(gl.SCISSOR_TEST);
    gl.viewport(0, 0, this.canvas.width, height);
    gl.clearColor(...film.background.map(each => each / 255), 1);
    gl.clearDepth(1);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.SCISSOR_TEST);
    this.wide = this.canvas.width;
    gl.depthFunc(gl.LEQUAL);
    film.panels.forEach((panel, number) => {
      const tracks = this.tracks.filter(track => track.panel === number);
      const clip = ([left, top, right, bottom]) => gl.scissor(Math.round(left * ratio), Math.round(height - bottom * ratio), Math.round((right - left) * ratio), Math.round((bottom - top) * ratio));
      clip(panel.rectangle);
      const shapes = tracks.filter(track => track.shapes).map(track => [track, this.shape(track, frame)]).filter(([, shape]) => shape);
      gl.enable(gl.BLEND);
      gl.disable(gl.DEPTH_TEST);
      gl.depthMask(false);
      this.plane = [0, 0, 0, 0];
      for (const [track, shape] of shapes) this[track.kind](track, shape, number, frame);
      const solid = tracks.filter(track => !track.shapes && track.deep);
      for (const [track, shape] of shapes) if (track.kind === "ground" && !shape.part) this.shadows(solid, shape, frame, share);
      this.plane = [0, 0, 0, 0];
      gl.enable(gl.DEPTH_TEST);
      gl.depthMask(true);
      gl.disable(gl.BLEND);
      gl.enable(gl.SAMPLE_ALPHA_TO_COVERAGE);
      const lights = track => ["halo", "density", "liquid"].includes(track.kind);
      for (const track of solid) if (!lights(track)) this.track(track, frame, share);
      gl.disable(gl.SAMPLE_ALPHA_TO_COVERAGE);
      gl.enable(gl.BLEND);
      gl.depthMask(false);
      for (const track of solid) if (lights(track)) this.track(track, frame, share);
      gl.disable(gl.DEPTH_TEST);
      const turned = !panel.flat && (this.turn !== STRAIGHT || this.zoom[0] !== 1);
      for (const track of tracks) if (!track.shapes && !track.deep && !turned) {
        clip(panel.flat && !track.still && !track.whole ? panel.free : panel.rectangle);
        this.track(track, frame, share);
      }
    });
  }
  shape(track, frame) {
    const known = Object.keys(track.shapes).map(Number).filter(each => each <= frame);
    return known.length ? track.shapes[Math.max(...known)] : null;
  }
  shadows(tracks, {normal, center}, frame, share) {
    const gl = this.gl, n = apply(this.turn, normal), c = apply(this.turn, center);
    if (dot(n, [-0.42, 0.62, 0.66]) < 0.1 || n[2] < 0) return;
    const casts = track => !track.still && (["line", "triangle", "surface", "solid", "liquid"].includes(track.kind) || (track.kind === "disc" && track.shading > 0));
    const cast = tracks.filter(casts);
    if (!cast.length) return;
    const end = this.beside("shadow", 2, gl.RGBA8);
    this.plane = [...n, dot(n, c)];
    for (const track of cast) this.track(track, frame, share);
    this.plane = [0, 0, 0, 0];
    end();
    this.over("dimmed", cast[0].panel, frame, {blur: 0.012 * Math.min(...this.film.size) * this.zoom[0]});
  }
  track(track, frame, share) {
    const gl = this.gl, at = track.still ? 0 : frame, between = track.still || !track.even ? 0 : share;
    const main = track.streams.places || track.streams.values || track.streams.real;
    if (!main || main.rows(at) === 0) return;
    this.use(track.kind, track.panel, track, frame, between);
    if (track.kind === "halo") {
      gl.blendFunc(track.shadow ? gl.ZERO : gl.ONE, gl.ONE_MINUS_SRC_COLOR);
      gl.uniform1i(this.now.uniforms.shadow, track.shadow);
    } else gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    this[`draw_${track.kind}`](track, at, between);
    this.finish();
  }
  square() { this.attribute("corner", "square", "corner", SQUARE, 2, 0, 2, 0); }
  inks(track, frame, divisor) { this.attribute("ink", track.id, "ink", track.streams.inks.at(frame), 4, 0, 4, divisor); }
  draw_disc(track, frame, share) {
    const gl = this.gl;
    this.square();
    this.places(track, frame, share, [["one", "other", 0]], 1);
    this.attribute("length_", track.id, "size", track.streams.sizes.real(frame, share), 1, 0, 1, 1);
    this.inks(track, frame, 1);
    gl.uniform1f(this.now.uniforms.shading, track.shading || 0);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, track.streams.places.rows(frame));
  }
  draw_halo(track, frame, share) { this.draw_disc(track, frame, share); }
  draw_density(track, frame, share) {
    const gl = this.gl;
    if (!this.fields) return;
    const scissor = gl.getParameter(gl.SCISSOR_BOX), end = this.beside("field", 1, gl.RGBA16F), {length_, ink} = this.programs.density.attributes;
    this.use("density", track.panel, track, frame, share);
    gl.blendFunc(gl.ONE, gl.ONE);
    gl.uniform1f(this.now.uniforms.amount, track.streams.light.real(frame, 0)[0] / (2 * Math.PI * track.spread ** 2));
    this.square();
    this.places(track, frame, share, [["one", "other", 0]], 1);
    gl.vertexAttrib1f(length_, 3 * track.spread * track.size);
    if (ink !== undefined) gl.vertexAttrib4f(ink, 1, 1, 1, 1);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, track.streams.places.rows(frame));
    this.finish();
    end();
    gl.scissor(...scissor);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    this.over("exposed", track.panel, frame, {}, () => this.texture(track.id, "table", 1, track.colors, 1, track.fixed("table").at(0), "color"));
  }
  draw_line(track, frame, share) {
    const gl = this.gl;
    this.square();
    this.places(track, frame, share, [["one", "other", 0], ["end", "endLater", track.deep ? 3 : 2]], 1);
    this.attribute("width", track.id, "size", track.streams.sizes.real(frame, share), 1, 0, 1, 1);
    this.inks(track, frame, 1);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, track.streams.places.rows(frame));
  }
  draw_triangle(track, frame, share) {
    this.places(track, frame, share, [["one", "other", 0]], 0, track.deep ? 3 : 2);
    this.inks(track, frame, 0);
    this.gl.drawArrays(this.gl.TRIANGLES, 0, 3 * track.streams.places.rows(frame));
  }
  draw_surface(track, frame, share) {
    const gl = this.gl, places = track.streams.places.real(frame, share), faces = track.streams.faces.at(frame), count = track.deep ? 3 : 2;
    this.attribute("one", track.id, "one", places, count, 0, count, 0);
    if (track.deep) this.attribute("normal", track.id, "normal", normals(places, faces), 3, 0, 3, 0);
    this.inks(track, frame, 0);
    gl.uniform1i(this.now.uniforms.closed, track.closed);
    this.sky(track.sky);
    gl.uniform4f(this.now.uniforms.back, ...(track.back || [0, 0, 0]).map(each => each / 255), track.back ? 1 : 0);
    gl.uniform1i(this.now.uniforms.textured, Boolean(track.texture));
    this.texture(track.id, "texels", 0, ...(track.texture || [1, 1]), track.texture ? track.fixed("texels").at(0) : WHITE, "color");
    if (track.texture) this.attribute("spot", track.id, "spot", track.fixed("spots").at(0), 2, 0, 2, 0);
    this.buffer(track.id, "faces", faces, gl.ELEMENT_ARRAY_BUFFER);
    gl.drawElements(gl.TRIANGLES, faces.length, gl.UNSIGNED_INT, 0);
  }
  draw_solid(track, frame, share) {
    const gl = this.gl, {turns} = track.streams, index = track.fixed("triangles").at(0);
    this.places(track, frame, share, [["one", "other", 0]], 1);
    this.attribute("way", track.id, "way", turns.at(frame), 4, 0, 4, 1);
    this.attribute("wayLater", track.id, "wayLater", turns.at(share > 0 ? frame + 1 : frame), 4, 0, 4, 1);
    gl.uniform4f(this.now.uniforms.lowTurn, ...turns.low);
    gl.uniform4f(this.now.uniforms.spanTurn, ...turns.span);
    this.inks(track, frame, 1);
    this.attribute("point", track.id, "point", track.fixed("points").at(0), 3, 0, 3, 0);
    this.attribute("normal", track.id, "normal", track.fixed("normals").at(0), 3, 0, 3, 0);
    this.attribute("tone", track.id, "tone", track.fixed("tones").at(0), 1, 0, 1, 0);
    gl.uniform1i(this.now.uniforms.closed, 1);
    this.sky(null);
    gl.uniform1i(this.now.uniforms.textured, 0);
    this.texture("none", "texels", 0, 1, 1, WHITE, "color");
    gl.enable(gl.CULL_FACE);
    this.buffer(track.id, "index", index, gl.ELEMENT_ARRAY_BUFFER);
    gl.drawElementsInstanced(gl.TRIANGLES, index.length, gl.UNSIGNED_INT, 0, track.streams.places.rows(frame));
    gl.disable(gl.CULL_FACE);
  }
  // A rectangle with corners in order, and the coordinates there.
  rectangle(key, corners, spots) {
    const gl = this.gl, count = corners[0].length, order = [0, 1, 3, 2];
    this.attribute("one", key, "corners", new Float32Array(order.flatMap(k => corners[k])), count, 0, count, 0);
    this.attribute("spot", key, "spots", new Float32Array(order.flatMap(k => spots[k])), 2, 0, 2, 0);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
  }
  draw_grid(track, frame, share) {
    const gl = this.gl, {values} = track.streams, uniforms = this.now.uniforms, walls = track.walls && track.fixed("walls");
    gl.uniform2f(uniforms.cells, ...track.cells);
    gl.uniform1f(uniforms.contours, track.contours);
    gl.uniform1f(uniforms.relief, track.relief);
    gl.uniform1f(uniforms.zero, track.zero);
    gl.uniform3f(uniforms.isoline, ...track.ink.map(each => each / 255));
    gl.uniform3f(uniforms.wall, ...track.wall.map(each => each / 255));
    gl.uniform1i(uniforms.walled, Boolean(walls));
    this.texture(track.id, "values", 0, ...track.cells, values.at(frame), "values");
    this.texture(track.id, "later", 1, ...track.cells, values.at(share > 0 ? frame + 1 : frame), "values");
    this.texture(track.id, "table", 2, 255, 1, track.fixed("table").at(0), "color");
    this.texture(track.id, "walls", 3, ...(walls ? track.cells : [1, 1]), walls ? walls.at(0) : WHITE.subarray(0, 1), "smooth");
    this.rectangle(track.id, track.corners, [[0, 0], [1, 0], [1, 1], [0, 1]]);
  }
  draw_phase(track, frame, share) {
    const gl = this.gl, uniforms = this.now.uniforms, later = share > 0 ? frame + 1 : frame;
    gl.uniform2f(uniforms.cells, ...track.cells);
    gl.uniform1f(uniforms.soft, track.soft);
    gl.uniform1f(uniforms.faint, track.faint);
    gl.uniform3f(uniforms.wall, ...track.wall.map(each => each / 255));
    gl.uniform1i(uniforms.walled, Boolean(track.walls));
    ["real", "imaginary"].forEach((name, k) => {
      this.texture(track.id, name, 2 * k, ...track.cells, track.streams[name].at(frame), "values");
      this.texture(track.id, `${name}Later`, 2 * k + 1, ...track.cells, track.streams[name].at(later), "values");
    });
    this.texture(track.id, "table", 4, track.colors, 1, track.fixed("table").at(0), "color");
    this.texture(track.id, "walls", 5, ...(track.walls ? track.cells : [1, 1]), track.walls ? track.fixed("walls").at(0) : WHITE.subarray(0, 1), "smooth");
    this.rectangle(track.id, track.corners, [[0, 0], [1, 0], [1, 1], [0, 1]]);
  }
  ground(track, {normal, center, size, color, along, grid, part, share}, panel, frame) {
    const n = apply(this.turn, normal), c = apply(this.turn, center), near = (this.film.eyes[panel] || [[0, 0, 0, 0]])[0][3];
    const across = cross(normal, along), wide = 3.4 * size;
    // From below, the ground is not seen.
    if (near > 0 ? dot(n, [0, 0, 1 / near]) < dot(n, c) : n[2] < 0) return;
    const corners = part || [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => center.map((each, k) => each + wide * (a * along[k] + b * across[k])));
    const spots = corners.map(each => { const from = each.map((value, k) => value - center[k]); return [dot(from, along) / size, dot(from, across) / size]; });
    const gl = this.gl;
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    this.use("ground", panel, track, frame, 0);
    gl.uniform4f(this.now.uniforms.tint, ...color.map(each => each / 255), part ? share : 0);
    gl.uniform4f(this.now.uniforms.grid, ...(grid ? grid[0] : [0, 0, 0]).map(each => each / 255), grid ? grid[2] : 0);
    gl.uniform1f(this.now.uniforms.pitch, grid ? grid[1] / size : 0);
    this.rectangle(track.id, corners, spots);
    this.finish();
  }
  backdrop(track, {center, radius, color, share}, panel, frame) {
    const gl = this.gl, [left, top, right, bottom] = this.film.panels[panel].rectangle;
    const corners = [[left, top], [right, top], [right, bottom], [left, bottom]], kept = this.zoom;
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    this.zoom = [1, 0, 0];
    this.use("backdrop", panel, {}, frame, 0);
    this.zoom = kept;
    gl.uniform4f(this.now.uniforms.tint, ...color.map(each => each / 255), share);
    this.rectangle(track.id, corners, corners.map(([x, y]) => [(x - center[0]) / radius, (y - center[1]) / radius]));
    this.finish();
  }
}
const SQUARE = new Float32Array([-1, -1, 1, -1, -1, 1, 1, 1]), WHITE = new Uint8Array([255, 255, 255, 255]);
