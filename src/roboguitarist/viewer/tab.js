"use strict";

/** The tablature as a strip that moves past a cursor; right notes turn green, missed ones red. */
class Tab {
  static NOW = 0.25;
  static SECONDS = 8;
  static COLOURS = {
    paper: "#181a1e", line: "#5c6068", bar: "#3a3d44", text: "#ebebe8", faint: "#969aa0", ink: "#121316",
    coming: "#ced0d4", right: "#60cd78", missed: "#f05c54", loop: "#e6c07b22",
  };

  constructor(canvas, data, player) {
    Object.assign(this, { canvas, data, player });
    this.missed = new Set(data.misses.map(([index]) => index));
    this.notes = data.notes.map(([onset, string, fret, duration, left, right], index) => ({
      onset, string, fret, duration, left, right, missed: this.missed.has(index),
    }));
    this._listen();
  }

  _listen() {
    let from = null;
    this.canvas.addEventListener("pointerdown", (event) => {
      from = { x: event.offsetX, time: this.player.time, moved: false };
      this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (!from || (!from.moved && Math.abs(event.offsetX - from.x) < 4)) return;
      from.moved = true;
      this.player.seek(from.time - (event.offsetX - from.x) / this.perSecond);
    });
    this.canvas.addEventListener("pointerup", (event) => {
      if (from && !from.moved) this.player.seek(from.time + (event.offsetX - Tab.NOW * this.width) / this.perSecond);
      from = null;
    });
    this.canvas.addEventListener("pointercancel", () => (from = null));
  }

  draw(time) {
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
      this.canvas.width = Math.round(width * ratio);
      this.canvas.height = Math.round(height * ratio);
    }
    Object.assign(this, { width, height, time, row: height * 0.125 });
    this.perSecond = Math.max(width / Tab.SECONDS, 90);
    this.pen = this.canvas.getContext("2d");
    this.pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.pen.fillStyle = Tab.COLOURS.paper;
    this.pen.fillRect(0, 0, width, height);
    this._drawLines();
    const first = time - (Tab.NOW * width) / this.perSecond - 0.5, last = first + width / this.perSecond + 1;
    const shown = this.notes.filter((note) => note.onset + note.duration >= first && note.onset <= last);
    for (const note of shown) this._drawTail(note);
    for (const note of shown) this._drawHead(note);
    this._drawPlucking(shown);
  }

  x(time) {
    return Tab.NOW * this.width + (time - this.time) * this.perSecond;
  }

  y(string) {
    return this.height * 0.15 + (string - 1) * this.row;
  }

  colour(note) {
    if (note.missed) return Tab.COLOURS.missed;
    return this.time < note.onset ? Tab.COLOURS.coming : Tab.COLOURS.right;
  }

  _drawLines() {
    const { pen, width } = this, top = this.y(1), bottom = this.y(6);
    const loop = this.player.loop;
    if (loop) {
      pen.fillStyle = Tab.COLOURS.loop;
      pen.fillRect(this.x(loop.fromS) - this.row, 0, (loop.toS - loop.fromS) * this.perSecond, this.height);
    }
    pen.lineWidth = 1;
    pen.font = `${Math.max(10, this.row * 0.55)}px system-ui, sans-serif`;
    pen.textAlign = "left";
    pen.textBaseline = "alphabetic";
    for (const [onset, number] of this.data.bars) {
      const x = this.x(onset) - 0.9 * this.row;
      if (x < -50 || x > width) continue;
      pen.strokeStyle = Tab.COLOURS.bar;
      this._stroke(x, top, x, bottom);
      pen.fillStyle = Tab.COLOURS.faint;
      pen.fillText(String(number), x + 2, top - 0.45 * this.row);
    }
    pen.strokeStyle = Tab.COLOURS.line;
    for (let string = 1; string <= 6; string++) this._stroke(0, this.y(string), width, this.y(string));
    pen.strokeStyle = Tab.COLOURS.text;
    pen.lineWidth = 2;
    this._stroke(Tab.NOW * width, top - 0.6 * this.row, Tab.NOW * width, bottom + 0.6 * this.row);
  }

  _stroke(x1, y1, x2, y2) {
    this.pen.beginPath();
    this.pen.moveTo(x1, y1);
    this.pen.lineTo(x2, y2);
    this.pen.stroke();
  }

  _drawTail(note) {
    const { pen } = this, start = this.x(note.onset);
    const length = Math.max(0, note.duration * this.perSecond - 0.7 * this.row);
    pen.globalAlpha = this.time < note.onset + note.duration ? 0.5 : 0.2;
    pen.fillStyle = this.colour(note);
    pen.fillRect(start, this.y(note.string) - 0.15 * this.row, length, 0.3 * this.row);
    pen.globalAlpha = 1;
  }

  _drawHead(note) {
    const { pen } = this, past = this.time >= note.onset + note.duration;
    const sounding = !past && this.time >= note.onset;
    const size = (sounding ? 1.15 : 0.98) * this.row, width = note.fret > 9 ? 1.4 * size : size;
    const x = this.x(note.onset), y = this.y(note.string);
    pen.fillStyle = Tab.COLOURS.paper;
    this._pill(x, y, width, size);
    pen.globalAlpha = past ? 0.65 : 1;
    pen.fillStyle = this.colour(note);
    this._pill(x, y, width, size);
    pen.globalAlpha = 1;
    pen.fillStyle = Tab.COLOURS.ink;
    pen.font = `600 ${0.8 * size}px system-ui, sans-serif`;
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.fillText(String(note.fret), x, y + 0.04 * size);
    if (!note.left) return;
    pen.fillStyle = this.data.fingers.left[note.left - 1];
    pen.font = `600 ${0.68 * this.row}px system-ui, sans-serif`;
    pen.textAlign = "left";
    pen.textBaseline = "alphabetic";
    pen.fillText(String(note.left), x + 0.62 * width, y - 0.14 * this.row);
  }

  _pill(x, y, width, height) {
    this.pen.beginPath();
    this.pen.roundRect(x - width / 2, y - height / 2, width, height, 0.42 * height);
    this.pen.fill();
  }

  _drawPlucking(shown) {
    const { pen } = this, together = new Map();
    for (const note of shown) together.set(note.onset, (together.get(note.onset) ?? new Set()).add(note.right));
    pen.font = `600 ${0.7 * this.row}px system-ui, sans-serif`;
    pen.textAlign = "center";
    pen.textBaseline = "top";
    for (const [onset, fingers] of together)
      [...fingers].sort((a, b) => b - a).forEach((finger, place) => {
        pen.fillStyle = this.data.fingers.right[finger];
        const x = this.x(onset) + (place - (fingers.size - 1) / 2) * 0.7 * this.row;
        pen.fillText("pima"[finger], x, this.y(6) + 0.65 * this.row);
      });
  }
}
