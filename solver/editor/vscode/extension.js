"use strict";

// Starts `backsolve lsp`, which does the rest.

const { workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

exports.activate = () => {
  const command = workspace.getConfiguration("backsolve").get("command");
  client = new LanguageClient(
    "backsolve",
    "Backsolve",
    { command, args: ["lsp"] },
    { documentSelector: [{ language: "tk" }] },
  );
  return client.start();
};

exports.deactivate = () => client && client.stop();
