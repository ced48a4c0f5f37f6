// Adapters for three.js: PSPLIT_mesh_draco_patches in GLTFLoader, and psplit in place of DRACOLoader.
export { loadStreaming } from './three/load_streaming.js';
export { PsplitDracoLoader } from './three/draco_loader.js';
export { PsplitPlugin } from './three/psplit_plugin.js';
