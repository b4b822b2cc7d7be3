"use strict";

// Runs the extension as an editor would, but for the editor: node extension.cjs VSCODE-FOLDER COMMAND.
// Starts what it starts, through the protocol library that it uses, and prints what the server says of a sheet.

const { spawn } = require("node:child_process");
const Module = require("node:module");
const [folder, command] = process.argv.slice(2);
const from = (name) => require.resolve(name, { paths: [folder, `${folder}/node_modules/vscode-languageclient`] });
const protocol = require(from("vscode-languageserver-protocol/node"));

const started = [];
class LanguageClient {
  constructor(id, name, server, client) {
    started.push({ id, server, client });
  }
  start() {}
  stop() {}
}
const stubs = {
  vscode: { workspace: { getConfiguration: () => ({ get: (name) => ({ command })[name] }) } },
  "vscode-languageclient/node": { LanguageClient },
};
const load = Module._load;
Module._load = (name, ...rest) => stubs[name] ?? load(name, ...rest);
require(`${folder}/${require(`${folder}/package.json`).main}`).activate();

const [{ server, client }] = started;
const child = spawn(server.command, server.args, { stdio: ["pipe", "pipe", "inherit"] });
const line = protocol.createProtocolConnection(
  new protocol.StreamMessageReader(child.stdout),
  new protocol.StreamMessageWriter(child.stdin),
);

async function main() {
  line.listen();
  const told = new Promise((done) => line.onNotification(protocol.PublishDiagnosticsNotification.type, done));
  const { capabilities } = await line.sendRequest(protocol.InitializeRequest.type, {
    processId: process.pid,
    rootUri: null,
    capabilities: {},
  });
  await line.sendNotification(protocol.InitializedNotification.type, {});
  const uri = "file:///tmp/sheet.tk";
  const textDocument = { uri, languageId: client.documentSelector[0].language, version: 1, text: "x = = 2\n" };
  await line.sendNotification(protocol.DidOpenTextDocumentNotification.type, { textDocument });
  const { diagnostics } = await told;
  const ended = new Promise((done) => child.on("exit", done));
  await line.sendRequest(protocol.ShutdownRequest.type);
  await line.sendNotification(protocol.ExitNotification.type);
  const codes = diagnostics.map(({ code }) => code);
  console.log(JSON.stringify({ capabilities: Object.keys(capabilities), codes, ended: await ended }));
}

main();
