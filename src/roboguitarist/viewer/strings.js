"use strict";

/** Strings that are seen to vibrate, in the guitar's frame (metres, x from nut to bridge). */
class Strings {
  static STEPS = 72;
  static AROUND = 6;
  static RADII_M = [0.00045, 0.0005, 0.0006, 0.0006, 0.0007, 0.0008];

  constructor(data) {
    this.guitar = data.guitar;
    this.rings = data.rings;
    this.group = new THREE.Group();
    this.lines = [];
    for (let string = 1; string <= 6; string++) this.lines.push(this._line(string));
  }

  y(string, x) {
    const { nut_span_m: nut, saddle_span_m: saddle, scale_length_m: length } = this.guitar;
    return ((nut + (saddle - nut) * (x / length)) * (3.5 - string)) / 5;
  }

  fretX(fret) {
    return this.guitar.scale_length_m * (1 - 2 ** (-fret / 12));
  }

  _line(string) {
    const wound = string >= 4;
    const material = new THREE.MeshStandardMaterial({
      color: wound ? 0xc9b384 : 0xf2f0e6, metalness: wound ? 0.8 : 0.1, roughness: wound ? 0.4 : 0.35,
    });
    const body = new THREE.Mesh(Strings._tube(), material);
    const blur = new THREE.Mesh(Strings._ribbon(), new THREE.MeshBasicMaterial({
      color: wound ? 0xd8c79c : 0xfffdf2, transparent: true, opacity: 0.4, depthWrite: false, side: 2,
    }));
    body.frustumCulled = blur.frustumCulled = false;
    body.castShadow = true;
    this.group.add(body, blur);
    return { string, body, blur, radius: Strings.RADII_M[string - 1], shown: NaN };
  }

  static _tube() {
    const { STEPS: n, AROUND: m } = Strings, index = [];
    for (let i = 0; i < n; i++)
      for (let k = 0; k < m; k++) {
        const a = i * m + k, b = i * m + ((k + 1) % m);
        index.push(a, b, b + m, a, b + m, a + m);
      }
    return Strings._geometry((n + 1) * m, index);
  }

  static _ribbon() {
    const index = [];
    for (let i = 0; i < Strings.STEPS; i++) index.push(2 * i, 2 * i + 1, 2 * i + 3, 2 * i, 2 * i + 3, 2 * i + 2);
    return Strings._geometry(2 * (Strings.STEPS + 1), index);
  }

  static _geometry(count, index) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setAttribute("normal", new THREE.BufferAttribute(new Float32Array(3 * count), 3));
    geometry.setIndex(index);
    return geometry;
  }

  /** Half the width of a string's swing in metres, and the fret that stops it. */
  swing(string, time) {
    let swing = { width: 0, fret: 0 };
    for (const [start, end, of, fret, width, decay] of this.rings) {
      if (start > time) break;
      if (of === string && time < end) swing = { width: width * Math.exp((-6.9 * (time - start)) / decay), fret };
    }
    return swing;
  }

  update(time) {
    for (const line of this.lines) {
      const { width, fret } = this.swing(line.string, time);
      const shown = width < 2e-5 ? 0 : width;
      if (shown === 0 && line.shown === 0) continue;
      line.shown = shown;
      // The eye cannot follow a string; this rate only looks like one.
      const now = shown * Math.sin(2 * Math.PI * (11 + 1.7 * line.string) * time);
      this._bend(line, this.fretX(fret), shown, now);
    }
  }

  _bend({ string, body, blur, radius }, stopX, width, now) {
    const { STEPS: n, AROUND: m } = Strings, length = this.guitar.scale_length_m;
    const points = body.geometry.attributes.position, normals = body.geometry.attributes.normal;
    const edges = blur.geometry.attributes.position;
    blur.visible = width > 0;
    for (let i = 0; i <= n; i++) {
      const x = (length * i) / n, u = (x - stopX) / (length - stopX);
      const shape = u > 0 ? Math.sin(Math.PI * u) : 0, y = this.y(string, x);
      for (let k = 0; k < m; k++) {
        const cos = Math.cos((2 * Math.PI * k) / m), sin = Math.sin((2 * Math.PI * k) / m);
        points.setXYZ(i * m + k, x, y + now * shape + radius * cos, radius * sin);
        normals.setXYZ(i * m + k, 0, cos, sin);
      }
      const half = width * shape + radius;
      edges.setXYZ(2 * i, x, y - half, 0);
      edges.setXYZ(2 * i + 1, x, y + half, 0);
    }
    points.needsUpdate = normals.needsUpdate = edges.needsUpdate = true;
  }
}
