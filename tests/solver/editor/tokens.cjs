"use strict";

// The tokens of sheets by the TextMate grammar, as JSON: node tokens.cjs VSCODE-FOLDER SHEET…

const fs = require("node:fs");
const [folder, ...sheets] = process.argv.slice(2);
const from = (name) => require.resolve(name, { paths: [folder] });
const { INITIAL, Registry, parseRawGrammar } = require(from("vscode-textmate"));
const { OnigScanner, OnigString, loadWASM } = require(from("vscode-oniguruma"));

async function main() {
  await loadWASM(fs.readFileSync(from("vscode-oniguruma/release/onig.wasm")));
  const onigLib = Promise.resolve({
    createOnigScanner: (patterns) => new OnigScanner(patterns),
    createOnigString: (text) => new OnigString(text),
  });
  const file = `${folder}/syntaxes/tk.tmLanguage.json`;
  const loadGrammar = async () => parseRawGrammar(fs.readFileSync(file, "utf8"), file);
  const grammar = await new Registry({ onigLib, loadGrammar }).loadGrammar("source.tk");
  const found = sheets.map((sheet) => {
    let state = INITIAL;
    return fs
      .readFileSync(sheet, "utf8")
      .split("\n")
      .map((line) => {
        const { tokens, ruleStack } = grammar.tokenizeLine(line, state);
        state = ruleStack;
        return tokens.map(({ scopes, startIndex, endIndex }) => [scopes.at(-1), line.slice(startIndex, endIndex)]);
      });
  });
  console.log(JSON.stringify(found));
}

main();
