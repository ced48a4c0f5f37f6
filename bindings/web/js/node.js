// Tells Node.js from browsers, and imports Node's own modules.
export const is_node = typeof process === 'object' && process.versions?.node !== undefined;
// Bundlers do not follow the import, because they do not know the name.
export const node_module = (name) => import(/* webpackIgnore: true */ /* @vite-ignore */ name);
