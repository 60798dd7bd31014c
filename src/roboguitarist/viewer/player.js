"use strict";

/** The sound and with it the page's clock: everything else follows `time`. */
class Player {
  /**
   * @param {Blob} sound - What to play.
   * @param {number} startS - Time in the piece of the sound's beginning, in seconds.
   * @param {number} endS - Time in the piece at which all is over.
   */
  constructor(sound, startS, endS) {
    this.startS = startS;
    this.endS = endS;
    this.loop = null;
    this.audio = new Audio();
    this.audio.preload = "auto";
    this.audio.preservesPitch = true;
    this.audio.src = URL.createObjectURL(sound);
    // Pages that are hidden draw nothing, but go on playing.
    this.audio.addEventListener("timeupdate", () => this.tick());
    this.audio.addEventListener("ended", () => this.loop && this.play(this.loop.fromS));
  }

  /** Time in the piece, in seconds; negative before its first bar. */
  get time() {
    return this.startS + this.audio.currentTime;
  }

  get playing() {
    return !this.audio.paused && !this.audio.ended;
  }

  seek(timeS) {
    const wanted = Math.min(Math.max(timeS, this.startS), this.endS);
    this.audio.currentTime = wanted - this.startS;
  }

  play(fromS) {
    if (fromS !== undefined) this.seek(fromS);
    else if (this.audio.ended) this.seek(this.loop ? this.loop.fromS : this.startS);
    return this.audio.play();
  }

  toggle() {
    if (this.playing) this.audio.pause();
    else this.play();
  }

  set speed(factor) {
    this.audio.playbackRate = factor;
    this.audio.defaultPlaybackRate = factor;
  }

  get speed() {
    return this.audio.playbackRate;
  }

  /** Repeat a stretch of the piece, or nothing if null. */
  setLoop(loop) {
    this.loop = loop;
    if (loop && (this.time < loop.fromS || this.time >= loop.toS)) this.seek(loop.fromS);
  }

  /** To be called before every picture. */
  tick() {
    if (this.loop && this.playing && !this.audio.seeking && this.time >= this.loop.toS)
      this.seek(this.loop.fromS);
  }
}
