// The files that a user gives, as one asset.

/**
 * @typedef {object} Asset
 * @property {string} name
 * @property {ArrayBuffer} bytes of the .glb, .gltf or .drc
 * @property {boolean} [is_stream] whether it is a Draco stream alone
 * @property {number} file_bytes of all files
 * @property {(url: string) => string} resolve the address of a file that the asset names
 */

const path_of = (file) => file.path_in_drop || file.webkitRelativePath || file.name;

/** @returns {Promise<Asset>} */
export async function asset_of(files) {
  const main = files.find(({ name }) => /\.(glb|gltf)$/i.test(name)) ?? files.find(({ name }) => /\.drc$/i.test(name));
  if (main === undefined) throw new Error(`${files.map(path_of).join(', ')}: not a .glb, .gltf or .drc`);
  const folder = path_of(main).slice(0, -main.name.length);
  const addresses = new Map(), made = [];
  const address_of = (file) => {
    if (!addresses.has(file)) addresses.set(file, made[made.push(URL.createObjectURL(file)) - 1]);
    return addresses.get(file);
  };
  const resolve = (url) => {
    if (/^(blob|data|https?):/.test(url)) return url;
    const path = decodeURIComponent(url).replace(/^(\.\/)+/, ''), name = path.split('/').pop();
    const file = files.find((other) => path_of(other) === folder + path) ?? files.find((other) => other.name === name);
    return file === undefined ? url : address_of(file);
  };
  return { name: main.name, bytes: await main.arrayBuffer(), is_stream: /\.drc$/i.test(main.name), file_bytes: files.reduce((sum, { size }) => sum + size, 0), resolve };
}

/** A sample of the page. @returns {Promise<Asset>} */
export async function sample_asset({ name, coding }, signal) {
  const file = `${name}.${coding}.glb`, response = await fetch(`samples/${file}`, { signal });
  if (!response.ok) throw new Error(`The sample ${file} is not there: HTTP status ${response.status}.`);
  const bytes = await response.arrayBuffer();
  return { name: file, bytes, file_bytes: bytes.byteLength, resolve: (url) => url };
}

/** Calls open(files) when files are dropped on the page. `hint` is shown while they are above it. */
export function on_drop(hint, open) {
  let drags = 0;
  addEventListener('dragenter', (event) => {
    event.preventDefault();
    ++drags;
    hint.hidden = false;
  });
  addEventListener('dragleave', () => (hint.hidden = --drags <= 0));
  addEventListener('dragover', (event) => event.preventDefault());
  addEventListener('drop', (event) => {
    event.preventDefault();
    drags = 0;
    hint.hidden = true;
    dropped_files(event.dataTransfer).then(open);
  });
}

// The files of a drop, also the files in its folders.
async function dropped_files({ items, files }) {
  // Entries are lost after the first wait.
  const entries = [...items].map((item) => item.webkitGetAsEntry?.()).filter((entry) => entry != null);
  if (entries.length === 0) return [...files];
  const files_of = async (entry) => {
    if (entry.isFile) {
      const file = await new Promise((resolve, reject) => entry.file(resolve, reject));
      return [Object.assign(file, { path_in_drop: entry.fullPath.slice(1) })];
    }
    const reader = entry.createReader(), children = [];
    for (let more; (more = await new Promise((resolve, reject) => reader.readEntries(resolve, reject))).length > 0;) children.push(...more);
    return (await Promise.all(children.map(files_of))).flat();
  };
  return (await Promise.all(entries.map(files_of))).flat();
}
