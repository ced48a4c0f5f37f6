// The canvas: shows a model, and its patches in colours.
import { Box3, DirectionalLight, DoubleSide, MeshStandardMaterial, NeutralToneMapping, PerspectiveCamera, PMREMGenerator, Scene,
  Vector3, WebGLRenderer } from './three/three.module.js';
import { OrbitControls } from './three/controls/OrbitControls.js';
import { RoomEnvironment } from './three/environments/RoomEnvironment.js';

const kColours = ['#4f7df3', '#f2a33c', '#37b58b', '#e2604f', '#9a6be0', '#3fb3d6', '#d9bf3f', '#e07bb0', '#7fb24a', '#5566c0',
  '#c98a5e', '#58c4a8'];

export function meshes_of(model) {
  const meshes = [];
  model?.traverse((object) => object.isMesh && meshes.push(object));
  return meshes;
}

/** Replaces glTF's default material, a white metal, which hardly shows a shape. */
export function show_shapes(model) {
  const is_default = ({ name, metalness, map, color }) => name === '' && metalness === 1 && !map && color.getHex() === 0xffffff;
  for (const { material } of meshes_of(model)) if (is_default(material)) material.setValues({ color: '#aeb7c6', metalness: 0, roughness: 0.6 });
}

/** Places a camera so that it sees a model from a direction. Returns the center of the model, or null if it is empty. */
export function frame(camera, model, direction) {
  const box = new Box3().setFromObject(model);
  if (box.isEmpty()) return null;
  const center = box.getCenter(new Vector3()), radius = box.getSize(new Vector3()).length() / 2 || 1;
  const narrow = Math.min(1, camera.aspect), distance = (0.85 * radius) / Math.sin((camera.fov * Math.PI) / 360) / narrow;
  camera.position.copy(center).addScaledVector(direction.clone().normalize(), distance);
  camera.near = distance / 200;
  camera.far = distance * 20;
  camera.updateProjectionMatrix();
  return center;
}

export class Stage {
  #renderer;
  #scene = new Scene();
  #camera = new PerspectiveCamera(40, 1, 0.01, 1000);
  #controls;
  #canvas;
  #model = null;
  #materials = new Map();  // of meshes: { own, coloured }
  #has_colours = true;
  #is_drawing = false;

  constructor(canvas) {
    this.#canvas = canvas;
    this.#renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.#renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    const environment = new PMREMGenerator(this.#renderer);
    this.#scene.environment = environment.fromScene(new RoomEnvironment(), 0.04).texture;
    this.#scene.environmentIntensity = 0.5;
    this.#renderer.toneMapping = NeutralToneMapping;
    const light = new DirectionalLight('#fff', 1);
    light.position.set(-1, 2, 1.5);
    this.#scene.add(light);
    environment.dispose();
    this.#controls = new OrbitControls(this.#camera, canvas);
    this.#controls.addEventListener('change', () => this.draw());
    new ResizeObserver(() => this.#resize()).observe(canvas.parentElement);
    canvas.addEventListener('keydown', (event) => this.#key(event));
    this.#resize();
  }

  /** Draws once, before the next frame of the page. */
  draw() {
    if (this.#is_drawing) return;
    this.#is_drawing = true;
    requestAnimationFrame(() => {
      this.#is_drawing = false;
      this.#renderer.render(this.#scene, this.#camera);
    });
  }

  /** @param {import('three').Object3D | null} model */
  show(model) {
    if (this.#model !== null) this.#remove(this.#model);
    this.#model = model;
    if (model !== null) {
      show_shapes(model);
      this.#scene.add(model);
      const center = frame(this.#camera, model, new Vector3(0.55, 0.5, 1));
      if (center !== null) this.#controls.target.copy(center);
      this.#controls.update();
    }
    this.draw();
  }

  get meshes() {
    return meshes_of(this.#model);
  }

  /** Colours ranges of faces of a mesh: [number of the patch, first face, end]. */
  colour(mesh, ranges) {
    const { geometry } = mesh;
    geometry.clearGroups();
    for (const [patch, first, end] of ranges) geometry.addGroup(3 * first, 3 * (end - first), patch % kColours.length);
    if (!this.#materials.has(mesh)) {
      const flatShading = geometry.attributes.normal === undefined;
      const coloured = kColours.map((color) =>
        new MeshStandardMaterial({ color, side: DoubleSide, flatShading, roughness: 0.55, metalness: 0 }));
      this.#materials.set(mesh, { own: mesh.material, coloured });
    }
    this.#assign();
  }
  set has_colours(value) {
    this.#has_colours = value;
    this.#assign();
  }
  #assign() {
    for (const [mesh, { own, coloured }] of this.#materials) mesh.material = this.#has_colours ? coloured : own;
    this.draw();
  }

  /** Shows the first faces of all meshes, in parts of 1. */
  set part(part) {
    for (const { geometry } of this.meshes) {
      const count = geometry.index?.count ?? geometry.attributes.position.count;
      geometry.setDrawRange(0, part >= 1 ? Infinity : 3 * Math.floor((part * count) / 3));
    }
    this.draw();
  }

  #remove(model) {
    this.#scene.remove(model);
    model.traverse((object) => object.geometry?.dispose());
    for (const { own, coloured } of this.#materials.values()) for (const material of [own, ...coloured].flat()) material.dispose();
    this.#materials.clear();
  }

  #key({ key }) {
    const { position } = this.#camera, { target } = this.#controls, offset = position.clone().sub(target);
    const turns = { ArrowLeft: [0, -0.1], ArrowRight: [0, 0.1], ArrowUp: [-0.1, 0], ArrowDown: [0.1, 0] };
    if (key in turns) {
      const [pitch, yaw] = turns[key];
      const limit = Math.PI / 2 - 0.05, at = Math.asin(offset.y / offset.length());
      const right = new Vector3(0, 1, 0).cross(offset).normalize();
      offset.applyAxisAngle(right, Math.abs(at - pitch) < limit ? pitch : 0).applyAxisAngle(new Vector3(0, 1, 0), yaw);
    } else if (key === '+' || key === '-') {
      offset.multiplyScalar(key === '+' ? 0.9 : 1.1);
    } else {
      return;
    }
    position.copy(target).add(offset);
    this.#controls.update();
    this.draw();
  }

  #resize() {
    const { clientWidth: width, clientHeight: height } = this.#canvas.parentElement;
    this.#renderer.setSize(width, height, false);
    this.#camera.aspect = width / Math.max(1, height);
    this.#camera.updateProjectionMatrix();
    this.draw();
  }
}
