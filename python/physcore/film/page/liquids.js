// How liquids are drawn: by pictures beside the canvas, from which the surface of many drops is found.
Object.assign(Drawing.prototype, {
  // A liquid in 3D; where pictures have no numbers, and in shadows, its drops.
  sea(track, frame, share) {
    const gl = this.gl, {streams} = track, drops = kind => { this.use(kind, track.panel, track, frame, share); this.draw_disc(track, frame, share); };
    if (!this.numbers || this.plane.some(Boolean)) { drops("disc"); return; }
    const scissor = gl.getParameter(gl.SCISSOR_BOX), size = streams.sizes.real(frame, share)[0], scale = this.film.eyes[track.panel][0][0] * this.zoom[0];
    const ball = size * scale * this.canvas.width / this.film.size[0], range = 4 * size;
    gl.disable(gl.DEPTH_TEST);
    let end = this.beside("field", 1, gl.RGBA16F);
    gl.blendFunc(gl.ONE, gl.ONE);
    drops("thick");
    this.finish();
    end();
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    gl.disable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    end = this.beside("front", 1, gl.RGBA32F);
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, -1e30]);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    drops("front");
    this.finish();
    end();
    gl.disable(gl.DEPTH_TEST);
    for (const [from, to, along] of [["front", "calm", [1, 0]], ["calm", "front", [0, 1]], ["front", "calm", [1, 0]], ["calm", "front", [0, 1]]]) {
      end = this.beside(to, 1, gl.RGBA32F);
      gl.bindTexture(gl.TEXTURE_2D, this.pictures[from].texture);
      this.over("calm", track.panel, frame, {reach: Math.ceil(Math.min(Math.max(1.5 * ball, 1), 32)), range}, () => gl.uniform2f(this.now.uniforms.along, ...along));
      end();
    }
    // What is seen through the liquid, and beside it the thickness.
    const behind = this.pictures.behind || (this.pictures.behind = {texture: gl.createTexture()});
    gl.activeTexture(gl.TEXTURE2);
    gl.bindTexture(gl.TEXTURE_2D, behind.texture);
    gl.copyTexImage2D(gl.TEXTURE_2D, 0, gl.RGB, 0, 0, this.canvas.width, this.canvas.height, 0);
    for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, side, gl.LINEAR);
    for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, this.pictures.field.texture);
    gl.scissor(...scissor);
    gl.enable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
    this.over("sea", track.panel, frame, {range, ball, steep: ball / size, glow: track.glow}, () => {
      const {uniforms} = this.now;
      gl.uniform1i(uniforms.thick, 1);
      gl.uniform1i(uniforms.behind, 2);
      this.sky(track.sky);
    });
    gl.depthMask(false);
  },
  draw_liquid(track, frame, share) {
    const gl = this.gl;
    if (track.deep) { this.sea(track, frame, share); return; }
    if (!this.fields) { this.use("disc", track.panel, track, frame, share); this.draw_disc(track, frame, share); return; }
    const scissor = gl.getParameter(gl.SCISSOR_BOX), end = this.beside("field", 1, gl.RGBA16F), sizes = track.streams.sizes.real(frame, share);
    this.use("liquid", track.panel, track, frame, share);
    gl.blendFunc(gl.ONE, gl.ONE);
    this.draw_disc(track, frame, share);
    this.finish();
    end();
    gl.scissor(...scissor);
    gl.generateMipmap(gl.TEXTURE_2D);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
    const reach = Math.min(Math.max(4 * sizes[0] * this.zoom[0], 1), 64) * this.wide / this.film.size[0];
    this.over("water", track.panel, frame, {glow: track.glow, blur: Math.log2(2 * reach)});
  },
});
