// One of two sides: loads a model in one way, draws it, and says what that took. The picture is drawn to a texture and copied to a canvas,
// so that the first frame is there when its pixels are, and pictures can be compared.
import { DirectionalLight, HemisphereLight, PerspectiveCamera, RenderTarget, Scene, SRGBColorSpace, Vector3 } from './three/three.module.js';
import { WebGPURenderer } from './three/three.webgpu.js';
import { createPool } from './psplit/index.js';
import { array_bytes, count_buffers, make_worker, watch_main_thread, worker_memory } from './costs.js';
import { load_asset } from './loading.js';
import { frame, meshes_of, show_shapes } from './scene.js';

const kSize = 512;
let sides = 0;

export class Side {
  pixels = null;  // of the last picture
  #context;
  #renderer;
  #buffers;  // undefined without WebGPU
  #target = new RenderTarget(kSize, kSize, { colorSpace: SRGBColorSpace, samples: 4 });
  #scene = new Scene().add(new HemisphereLight('#fff', '#556', 2));
  #camera = new PerspectiveCamera(40, 1, 0.01, 1000);
  #pool = null;
  #model = null;
  #is_on_gpu;
  #name = `workers of side ${++sides}`;

  /** @param {HTMLCanvasElement} canvas @param {{ is_on_gpu: boolean, has_webgpu: boolean, signal: AbortSignal }} way @returns {Promise<Side>} */
  static async make(canvas, { is_on_gpu, has_webgpu, signal }) {
    const side = new Side(), renderer = new WebGPURenderer({ canvas: document.createElement('canvas'), forceWebGL: !has_webgpu });
    await renderer.init();
    if (signal.aborted) renderer.dispose();
    signal.throwIfAborted();
    side.#context = Object.assign(canvas, { width: kSize, height: kSize }).getContext('2d');
    side.#renderer = renderer;
    side.#is_on_gpu = is_on_gpu;
    // three falls back to WebGL if it gets no device.
    if (renderer.backend.device) side.#buffers = count_buffers(renderer.backend.device);
    const light = new DirectionalLight('#fff', 2);
    light.position.set(-1, 2, 1.5);
    side.#scene.add(light);
    renderer.setClearColor(0, 0);
    return side;
  }

  /**
   * Loads and draws a model. The first time, workers start, WebAssembly is loaded, and shaders are compiled.
   * @returns {Promise<{ frame_ms: number, blocked: number, longest: number }>}
   */
  async load(asset, { workers, direction, signal }) {
    this.#remove_model();
    this.#pool ??= createPool({ workers, worker: () => make_worker(this.#name) });
    const end = watch_main_thread(), begin = performance.now();
    try {
      const gltf = await load_asset(asset, { pool: this.#pool, signal, ...(this.#is_on_gpu && { gpu: this.#renderer }) });
      this.#model = gltf.scene;
      signal.throwIfAborted();
      show_shapes(gltf.scene);
      this.#scene.add(gltf.scene);
      await this.draw(direction, signal);
      this.meshes = meshes_of(gltf.scene).map((mesh) => ({ name: mesh.name, triangles: (mesh.geometry.index ?? mesh.geometry.attributes.position).count / 3,
        patches: gltf.psplit.patchesOf(mesh) }));
      return { frame_ms: performance.now() - begin, ...end() };
    } finally {
      end();
    }
  }

  async draw(direction, signal) {
    if (this.#model === null) return;
    const [yaw, pitch] = direction, center = frame(this.#camera, this.#model, new Vector3(Math.sin(yaw) * Math.cos(pitch), Math.sin(pitch), Math.cos(yaw) * Math.cos(pitch)));
    this.#camera.lookAt(center ?? new Vector3());
    this.#renderer.setRenderTarget(this.#target);
    this.#renderer.render(this.#scene, this.#camera);
    const pixels = new Uint8ClampedArray(await this.#renderer.readRenderTargetPixelsAsync(this.#target, 0, 0, kSize, kSize));
    signal?.throwIfAborted();  // the canvas may be another side's by now
    // WebGL's first row is the lowest one.
    const rows = this.#buffers !== undefined ? pixels : Uint8ClampedArray.from(pixels, (_, i) => pixels[i + 4 * kSize * (kSize - 1 - 2 * Math.floor(i / 4 / kSize))]);
    this.#context.putImageData(new ImageData((this.pixels = rows), kSize), 0, 0);
  }

  /** The memory of the model: bytes; undefined where a page cannot know. */
  async memory() {
    return { wasm: await worker_memory(this.#name, this.#pool.workerCount), arrays: array_bytes(meshes_of(this.#model)), buffers: this.#buffers?.now, most_buffers: this.#buffers?.most };
  }

  dispose() {
    this.#remove_model();
    this.#pool?.dispose();
    this.#target.dispose();
    this.#renderer.dispose();
    this.#renderer.backend.device?.destroy();
  }
  #remove_model() {
    if (this.#model === null) return;
    this.#scene.remove(this.#model);
    for (const { geometry, material } of meshes_of(this.#model)) for (const each of [geometry, material].flat()) each.dispose();
    this.#model = null;
  }
}
