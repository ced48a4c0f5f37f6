// The package's types beside three-stdlib's, which drei's useGLTF has. types_test.mjs compiles it; it never runs.
import type { Pool } from 'psplit';
import { PsplitDracoLoader, PsplitPlugin } from 'psplit/three';
import { GLTFLoader } from 'three-stdlib';

// Use it as useGLTF(path, useDraco, useMeshopt, extend(pool)).
export function extend(pool: Pool): (loader: GLTFLoader) => void {
  return (loader) => {
    loader.register((parser) => new PsplitPlugin(parser, { pool }));
    loader.setDRACOLoader(new PsplitDracoLoader({ pool }));
  };
}
