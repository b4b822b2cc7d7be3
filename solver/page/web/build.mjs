// Builds src into ../static, or into the folder that is named: the same input gives the same bytes.
import { build } from "esbuild";
import { copyFile, mkdir, readFile, rm, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, "..", "static");
const shared = {
  absWorkingDir: here,
  bundle: true,
  minify: true,
  target: "es2022",
  charset: "utf8",
  legalComments: "none",
  jsx: "automatic",
  jsxImportSource: "preact",
};

// Of KaTeX's twenty fonts the page uses these; the others are left out with their rules.
const fonts = /KaTeX_(Main-Regular|Main-Italic|Math-Italic|Size[1-4]-Regular)\.woff2/;
const fewFonts = {
  name: "few-fonts",
  setup(bundler) {
    bundler.onLoad({ filter: /katex\.min\.css$/ }, async ({ path }) => {
      const text = await readFile(path, "utf8");
      const faces = (face) => (fonts.test(face) ? face.replace(/,url\([^)]*\.(woff|ttf)\) format\("\w+"\)/g, "") : "");
      return { contents: text.replace(/@font-face\{[^}]*\}/g, faces), loader: "css" };
    });
  },
};

// A cell has its own style, in a shadow tree: the style sheet comes as a text.
const cssAsText = {
  name: "css-as-text",
  setup(bundler) {
    bundler.onLoad({ filter: /page\.css$/ }, async ({ path }) => {
      const bundled = await build({ ...shared, entryPoints: [path], write: false });
      return { contents: bundled.outputFiles[0].text.trim(), loader: "text" };
    });
  },
};

await rm(out, { recursive: true, force: true });
await mkdir(out, { recursive: true });
await build({
  ...shared,
  entryPoints: ["src/page.tsx"],
  format: "esm",
  splitting: true,
  outdir: out,
  chunkNames: "[name]-[hash]",
  assetNames: "[name]",
  loader: { ".woff2": "file" },
  plugins: [fewFonts],
});
await build({
  ...shared,
  entryPoints: ["src/export.tsx"],
  format: "iife",
  outdir: out,
});
await build({
  ...shared,
  entryPoints: ["src/widget.tsx"],
  format: "esm",
  plugins: [cssAsText],
  outdir: out,
});
for (const name of ["index.html", "icon.svg"]) await copyFile(join(here, "src", name), join(out, name));

const licences = ["preact", "@preact/signals", "@preact/signals-core", "katex"].map(async (name) => {
  const text = await readFile(join(here, "node_modules", name, "LICENSE"), "utf8");
  return `${name}\n\n${text.trim()}\n`;
});
await writeFile(join(out, "licences.txt"), (await Promise.all(licences)).join("\n\n"));
