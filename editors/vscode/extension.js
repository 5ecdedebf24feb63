// Starts `sgap lsp` and joins it to the editor. Everything that is known of the language is in that program.
'use strict';

const { workspace } = require('vscode');
const { LanguageClient } = require('vscode-languageclient/node');

let client;

function activate() {
  const server = {
    command: workspace.getConfiguration('sgap').get('path', 'sgap'),
    args: ['lsp', '--stdio'],
  };
  client = new LanguageClient('sgap', 'sgap', server, { documentSelector: [{ language: 'hatp' }] });
  return client.start();
}

function deactivate() {
  return client ? client.stop() : undefined;
}

module.exports = { activate, deactivate };
