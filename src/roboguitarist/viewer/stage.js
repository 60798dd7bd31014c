"use strict";

/** The 3D scene: hands and guitar from the GLB, strings, and marks of what is pressed and missed. */
class Stage {
  static MISSED = 0xf0443a;
  static ASPECT = 16 / 9;
  /** Pictures slower than this many milliseconds make the scene plainer. */
  static SLOW_MS = 90;

  static async create(canvas, glb, data) {
    const gltf = await new THREE.GLTFLoader().parseAsync(glb, "");
    return new Stage(canvas, gltf, data);
  }

  constructor(canvas, gltf, data) {
    this.data = data;
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.setClearAlpha(0);
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(32, Stage.ASPECT, 0.01, 20);
    this.root = gltf.scene;
    this.guitar = this.root.getObjectByName("roboguitarist");
    this.scene.add(this.root);
    this.root.traverse((node) => {
      if (node.isMesh) node.castShadow = node.receiveShadow = true;
      if (/^string_\d_seen$/.test(node.name)) node.visible = false;
    });
    this._light();
    this._animate(gltf.animations);
    this.strings = new Strings(data);
    this.guitar.add(this.strings.group);
    this._addMarks();
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.enableDamping = true;
    this.controls.minDistance = 0.1;
    this.controls.maxDistance = 3;
    this.controls.addEventListener("start", () => this.view(null));
    this.onview = () => {};
    this.detail = 2;
    this.view("front");
  }

  get views() {
    return ["front", "left", "right", "player"];
  }

  /** Look from a named camera, or leave the camera to the hand on the mouse. */
  view(name) {
    this.follow = name && this.root.getObjectByName(`camera_${name}`);
    this.viewName = this.follow ? name : null;
    if (this.follow) this._followCamera();
    if (this.onview) this.onview(this.viewName);
  }

  /** Show the moment `time`, in seconds of the piece. */
  setTime(time) {
    this.time = time;
    if (this.action) {
      this.action.paused = false;
      this.action.time = Math.min(Math.max(time - this.data.start_s, 0), this.length - 1e-4);
      this.mixer.update(0);
    }
    this.strings.update(time);
    this._showMarks(time);
  }

  render() {
    this._resize();
    if (this.follow) this._followCamera();
    else this.controls.update();
    this.renderer.render(this.scene, this.camera);
  }

  /** Told how long the last picture took, leave out what a machine without graphics cannot do. */
  pace(ms) {
    if (document.hidden || ms > 2000) return;
    this.ms = 0.8 * (this.ms ?? 0) + 0.2 * ms;
    if (this.ms > Stage.SLOW_MS && this.detail > 0) this.simplify();
  }

  /** Without shadows; called again, with fewer pixels. */
  simplify() {
    this.detail -= 1;
    this.ms = 0;
    if (this.detail === 1) {
      this.renderer.shadowMap.enabled = false;
      this.root.traverse((node) => node.isMesh && (node.material.needsUpdate = true));
    }
  }

  _light() {
    const generator = new THREE.PMREMGenerator(this.renderer);
    this.scene.environment = generator.fromScene(new THREE.RoomEnvironment(), 0.04).texture;
    this.scene.environmentIntensity = 0.38;
    const key = new THREE.DirectionalLight(0xfff4e2, 2.0);
    key.position.set(0.35, 0.9, 1.1);
    key.target.position.set(-0.33, 0, 0);
    key.castShadow = true;
    key.shadow.mapSize.set(2048, 2048);
    Object.assign(key.shadow.camera, { left: -0.75, right: 0.75, top: 0.75, bottom: -0.75, near: 0.1, far: 3 });
    key.shadow.bias = -0.0003;
    key.shadow.normalBias = 0.001;
    key.shadow.radius = 4;
    const fill = new THREE.DirectionalLight(0xdfe9ff, 0.4);
    fill.position.set(-1.2, 0.3, 0.8);
    this.scene.add(key, key.target, fill);
  }

  _animate([clip]) {
    if (!clip) return;
    this.mixer = new THREE.AnimationMixer(this.root);
    this.action = this.mixer.clipAction(clip);
    this.action.play();
    this.length = clip.duration;
  }

  _addMarks() {
    const plane = new THREE.PlaneGeometry(1, 1);
    const mark = (color, opacity) => {
      const mesh = new THREE.Mesh(plane, new THREE.MeshBasicMaterial({
        color, transparent: true, opacity, depthWrite: false, side: 2, toneMapped: false,
      }));
      mesh.visible = false;
      this.guitar.add(mesh);
      return mesh;
    };
    this.pressed = Array.from({ length: 12 }, () => mark(0xffffff, 0.95));
    this.wanted = Array.from({ length: 6 }, () => mark(Stage.MISSED, 0.95));
    const ball = new THREE.SphereGeometry(0.004, 16, 12);
    this.plucked = Array.from({ length: 6 }, () => {
      const mesh = new THREE.Mesh(ball, new THREE.MeshBasicMaterial({ transparent: true, toneMapped: false }));
      mesh.visible = false;
      this.guitar.add(mesh);
      return mesh;
    });
  }

  /** Lay a bar over a fret space on one string. */
  _lay(mesh, string, fret, height) {
    const from = this.strings.fretX(Math.max(fret - 1, 0)), to = this.strings.fretX(fret);
    const open = fret === 0, x = open ? -0.006 : (from + to) / 2;
    mesh.position.set(x, this.strings.y(string, x), open ? 0.002 : height - this.data.guitar.action_m);
    mesh.scale.set(open ? 0.008 : (to - from) * 0.9, 0.0052, 1);
    mesh.visible = true;
  }

  _showMarks(time) {
    for (const mesh of [...this.pressed, ...this.wanted, ...this.plucked]) mesh.visible = false;
    const tick = 1 / this.data.control_hz;
    this.data.presses
      .filter(([start, end]) => start - tick / 2 <= time && time < end + tick / 2)
      .slice(0, this.pressed.length)
      .forEach(([, , string, fret, finger], k) => {
        this.pressed[k].material.color.set(this.data.fingers.left[finger - 1]);
        this._lay(this.pressed[k], string, fret, 0.0003);
      });
    this.data.misses
      .map(([index]) => this.data.notes[index])
      .filter(([onset, , , duration]) => onset <= time && time < onset + Math.max(duration, 0.3))
      .slice(0, this.wanted.length)
      .forEach(([, string, , , , , stop], k) => this._lay(this.wanted[k], string, stop, 0.0006));
    for (const [at, string, x, finger] of this.data.plucks) {
      const age = time - at;
      if (age < 0 || age > 0.3) continue;
      const mesh = this.plucked[string - 1];
      mesh.position.set(x, this.strings.y(string, x), 0.003);
      mesh.material.color.set(this.data.fingers.right[finger]);
      mesh.material.opacity = 1 - age / 0.3;
      mesh.visible = true;
    }
  }

  _resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const finest = [0.6, 1, 2][this.detail];
    const ratio = Math.min(window.devicePixelRatio || 1, finest);
    if (this.width === width && this.height === height && this.ratio === ratio) return;
    Object.assign(this, { width, height, ratio });
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
    this._lens();
  }

  /** Narrow windows see as much from left to right as wide ones. */
  _lens() {
    const half = Math.tan(((this.fov ?? 32) * Math.PI) / 360);
    const aspect = this.width / Math.max(this.height, 1);
    const wider = Math.max(1, Stage.ASPECT / aspect);
    this.camera.aspect = aspect;
    this.camera.fov = (Math.atan(half * wider) * 360) / Math.PI;
    this.camera.updateProjectionMatrix();
  }

  _followCamera() {
    const node = this.follow, place = new THREE.Vector3(), turn = new THREE.Quaternion();
    this.root.updateWorldMatrix(true, true);
    node.matrixWorld.decompose(place, turn, new THREE.Vector3());
    this.camera.position.copy(place);
    this.camera.quaternion.copy(turn);
    const lens = node.isCamera ? node : node.children.find((child) => child.isCamera);
    if (lens && this.fov !== lens.fov) {
      this.fov = lens.fov;
      this._lens();
    }
    // To go on from here by hand, turn around the point of the strings' plane that is looked at.
    const forward = new THREE.Vector3(0, 0, -1).applyQuaternion(turn);
    const distance = Math.abs(place.z / Math.min(forward.z, -0.2));
    this.controls?.target.copy(place).addScaledVector(forward, distance);
  }
}
