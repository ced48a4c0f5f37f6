// The output is a module, as index.html loads it.
export default {
  mode: 'production',
  entry: './main.js',
  output: { path: new URL('./dist/webpack', import.meta.url).pathname, filename: 'main.js', module: true },
  experiments: { outputModule: true },
};
