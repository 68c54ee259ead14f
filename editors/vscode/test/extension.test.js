'use strict';
// The extension, with a stand-in for VS Code and with the program itself.

const assert = require('node:assert/strict');
const { mkdtempSync, realpathSync, writeFileSync } = require('node:fs');
const { tmpdir } = require('node:os');
const path = require('node:path');
const Module = require('node:module');
const test = require('node:test');
const editor = require('../stand-in/vscode.js');

const load = Module._load;
Module._load = (name, ...rest) => (name === 'vscode' ? editor.api : load(name, ...rest));
const extension = require('../extension.js');

const program = process.env.CORROBORATE || 'corroborate';
const folder = realpathSync(mkdtempSync(path.join(tmpdir(), 'corroborate-')));
const context = { subscriptions: [] };
const { state } = editor;

const written = (name, text) => {
  const file = path.join(folder, name);
  writeFileSync(file, text);
  return file;
};
const found = (document) => state.diagnostics.get(document.uri.toString()) || [];
const codes = (document) => found(document).map((it) => (it.code && it.code.value !== undefined ? it.code.value : it.code));

test('a program that is not there is told once, with what can be done', async () => {
  state.settings['corroborate.path'] = path.join(folder, 'no-such-program');
  await extension.activate(context);
  await editor.until(() => state.messages.length > 0, 'a message');
  const told = state.messages.filter((it) => it.message.startsWith('Corroborate: the program'));
  assert.equal(told.length, 1);
  assert.match(told[0].message, /no-such-program` cannot be started .*corroborate\.path/s);
  assert.deepEqual(told[0].choices, ['Open the setting']);
});

test('the program is started once the setting names it, and tells mistakes', async () => {
  editor.set('corroborate.path', program);
  await editor.until(() => state.providers.registerHoverProvider, 'a hover provider');
  const document = editor.open(written('m.prism', 'dtmc\nmodule m é x : bool;\n  [] z -> true;\nendmodule\n'), 'prism');
  await editor.until(() => found(document).length > 0, 'diagnostics');
  assert.ok(codes(document).includes('invalid-character'), JSON.stringify(found(document)));
  editor.change(document, 'dtmc\nmodule m\n  x : bool;\n  [] z -> true;\nendmodule\n');
  await editor.until(() => codes(document).includes('unknown-name'), 'the other mistake');
  const mistake = found(document)[0];
  assert.deepEqual([mistake.range.start.line, mistake.range.start.character], [3, 5]);
  const link = mistake.code.target.toString();
  const page = await state.contents['corroborate-explain'].provideTextDocumentContent(editor.api.Uri.parse(link));
  assert.match(page, /^unknown-name\n\n.{40}/s);
  editor.change(document, 'dtmc\nmodule m\n  x : bool;\n  [] x -> true;\nendmodule\n');
  await editor.until(() => found(document).length === 0, 'no mistakes');
});

test('hover, definition and rename are asked of the program', async () => {
  const document = editor.open(written('n.prism', 'dtmc const int n = 2*3; module m x : [0..n]; endmodule'), 'prism');
  const { token } = new editor.api.CancellationTokenSource();
  const at = new editor.api.Position(0, 15);
  const hover = await state.providers.registerHoverProvider.provider.provideHover(document, at, token);
  assert.match(JSON.stringify(hover), /value: 6/);
  const definition = await state.providers.registerDefinitionProvider.provider.provideDefinition(document, at, token);
  assert.equal([].concat(definition).length, 1);
  const rename = state.providers.registerRenameProvider.provider;
  const changed = await rename.provideRenameEdits(document, at, 'count', token);
  const texts = JSON.stringify(changed.edits || changed.entries);
  assert.equal(texts.split('"count"').length - 1, 2, texts);
  await assert.rejects(rename.provideRenameEdits(document, at, 'x', token), /already a name/);
});

test('it stops', async () => {
  await extension.deactivate();
  assert.equal(state.providers.registerHoverProvider, undefined);
  context.subscriptions.forEach((it) => it.dispose());
});
