'use strict';
// A stand-in for the programming interface of VS Code: documents that are opened, changed and closed, and what an extension registers.
// Only what the extension and its client use does something; other classes are empty, so that they can be derived from.

const { EventEmitter: NodeEmitter } = require('node:events');
const { readFileSync } = require('node:fs');
const { fileURLToPath, pathToFileURL } = require('node:url');

class Disposable {
  constructor(call) { this.call = call; }
  dispose() { if (this.call) this.call(); this.call = undefined; }
  static from(...all) { return new Disposable(() => all.forEach((it) => it.dispose())); }
}

class EventEmitter {
  constructor() {
    this.emitter = new NodeEmitter();
    this.emitter.setMaxListeners(0);
    this.event = (listener, self, disposables) => {
      const call = (value) => listener.call(self, value);
      this.emitter.on('it', call);
      const registered = new Disposable(() => this.emitter.off('it', call));
      if (disposables) disposables.push(registered);
      return registered;
    };
  }
  fire(value) { this.emitter.emit('it', value); }
  dispose() { this.emitter.removeAllListeners(); }
}

class CancellationTokenSource {
  constructor() {
    this.cancelled = new EventEmitter();
    this.token = { isCancellationRequested: false, onCancellationRequested: this.cancelled.event };
  }
  cancel() { this.token.isCancellationRequested = true; this.cancelled.fire(); }
  dispose() {}
}

class Position {
  constructor(line, character) { this.line = line; this.character = character; }
}

class Range {
  constructor(a, b, c, d) {
    [this.start, this.end] = a instanceof Position ? [a, b] : [new Position(a, b), new Position(c, d)];
  }
}

class Uri {
  constructor(text) {
    const parsed = new URL(text);
    this.text = text;
    this.scheme = parsed.protocol.slice(0, -1);
    this.path = decodeURIComponent(parsed.pathname);
    this.fsPath = this.scheme === 'file' ? fileURLToPath(text) : this.path;
  }
  static parse(text) { return new Uri(text); }
  static file(path) { return new Uri(pathToFileURL(path).href); }
  toString() { return this.text; }
  with(change) { return new Uri(`${change.scheme || this.scheme}:${this.path}`); }
  toJSON() { return this.text; }
}

class Diagnostic {
  constructor(range, message, severity) { Object.assign(this, { range, message, severity }); }
}

class WorkspaceEdit {
  constructor() { this.edits = []; }
  replace(uri, range, text) { this.edits.push({ uri, range, text }); }
}

class Document {
  constructor(path, languageId, text) {
    Object.assign(this, { uri: Uri.file(path), languageId, version: 1, text, isClosed: false, isDirty: false });
    this.fileName = path;
  }
  getText() { return this.text; }
  get lineCount() { return this.text.split('\n').length; }
}

const events = {};
const on = (name) => (events[name] = events[name] || new EventEmitter()).event;
const state = { documents: [], diagnostics: new Map(), providers: {}, commands: {}, messages: [], contents: {}, settings: {}, output: [] };

const workspace = {
  get textDocuments() { return state.documents; },
  notebookDocuments: [],
  workspaceFolders: undefined,
  getConfiguration: (section) => ({ get: (key, otherwise) => state.settings[`${section}.${key}`] ?? otherwise, inspect: () => undefined }),
  createFileSystemWatcher: () => ({ onDidCreate: on('created'), onDidChange: on('changedFile'), onDidDelete: on('deleted'), dispose() {} }),
  registerTextDocumentContentProvider: (scheme, provider) => { state.contents[scheme] = provider; return new Disposable(); },
  applyEdit: async () => true,
};
for (const name of ['onDidOpenTextDocument', 'onDidChangeTextDocument', 'onDidCloseTextDocument', 'onDidSaveTextDocument',
  'onWillSaveTextDocument', 'onDidChangeConfiguration', 'onDidChangeWorkspaceFolders', 'onDidCreateFiles', 'onDidRenameFiles',
  'onDidDeleteFiles', 'onWillCreateFiles', 'onWillRenameFiles', 'onWillDeleteFiles', 'onDidOpenNotebookDocument',
  'onDidCloseNotebookDocument', 'onDidChangeNotebookDocument', 'onDidSaveNotebookDocument']) workspace[name] = on(name);

/** As VS Code decides it, for the selectors that the extension has. */
function matches(selector, document) {
  return [].concat(selector).some((it) =>
    (!it.language || it.language === document.languageId) &&
    (!it.scheme || it.scheme === document.uri.scheme) &&
    (!it.pattern || document.fileName.endsWith(it.pattern.replace('**/*', ''))));
}

const languages = new Proxy({
  match: (selector, document) => (matches(selector, document) ? 10 : 0),
  createDiagnosticCollection: () => ({
    set: (uri, found) => state.diagnostics.set(uri.toString(), found || []),
    delete: (uri) => state.diagnostics.delete(uri.toString()),
    clear: () => state.diagnostics.clear(),
    dispose() {},
  }),
}, {
  get: (own, name) => own[name] || (String(name).startsWith('register')
    ? (selector, provider) => { state.providers[name] = { selector, provider }; return new Disposable(() => delete state.providers[name]); }
    : undefined),
});

const window = {
  createOutputChannel: (name) => ({ name, append: (it) => state.output.push(it), appendLine: (it) => state.output.push(it), replace() {}, clear() {}, show() {}, hide() {}, dispose() {} }),
  showErrorMessage: async (message, ...choices) => { state.messages.push({ message, choices }); return undefined; },
  showWarningMessage: async (message) => { state.messages.push({ message }); return undefined; },
  showInformationMessage: async (message) => { state.messages.push({ message }); return undefined; },
  onDidChangeActiveTextEditor: on('active'),
  onDidChangeVisibleTextEditors: on('visible'),
  visibleTextEditors: [],
  tabGroups: { all: [], onDidChangeTabs: on('tabs'), onDidChangeTabGroups: on('groups') },
};

const commands = {
  registerCommand: (name, call) => { state.commands[name] = call; return new Disposable(() => delete state.commands[name]); },
  executeCommand: async (name, ...rest) => (state.commands[name] ? state.commands[name](...rest) : undefined),
};

const known = {
  version: '1.90.0', Disposable, EventEmitter, CancellationTokenSource, Position, Range, Uri, Diagnostic, WorkspaceEdit, workspace, languages, window, commands,
  env: { appName: 'stand-in', language: 'en' },
  extensions: { getExtension: () => undefined, all: [], onDidChange: on('extensions') },
  DiagnosticSeverity: { Error: 0, Warning: 1, Information: 2, Hint: 3 },
  l10n: { t: (text) => text },
};

// Enumerations as numbers, all else as a class.
const enumerations = /(Kind|Type|Reason|Level|Tag|Format|Severity|Status|State|Behavior|Rule)$/;
const made = {};
const api = new Proxy(known, {
  get: (own, name) => {
    if (name in own || typeof name !== 'string') return own[name];
    made[name] = made[name] || (enumerations.test(name)
      ? new Proxy({}, { get: (_, key) => (typeof key === 'string' && /^[A-Z]/.test(key) ? key.length : undefined) })
      : { [name]: class { constructor(...all) { this.given = all; } } }[name]);
    return made[name];
  },
});

/** Opens a file, as somebody who works with the editor does. */
function open(path, languageId, text = readFileSync(path, 'utf8')) {
  const document = new Document(path, languageId, text);
  state.documents.push(document);
  events.onDidOpenTextDocument.fire(document);
  return document;
}

/** Types: all of the text is another. */
function change(document, text) {
  const lines = document.text.split('\n');
  const range = new Range(new Position(0, 0), new Position(lines.length - 1, lines.at(-1).length));
  document.text = text;
  document.version += 1;
  events.onDidChangeTextDocument.fire({ document, contentChanges: [{ range, rangeOffset: 0, rangeLength: 0, text }] });
}

/** Sets a setting. */
function set(key, value) {
  state.settings[key] = value;
  events.onDidChangeConfiguration.fire({ affectsConfiguration: (it) => key === it || key.startsWith(`${it}.`) });
}

/** Waits until something is so. */
async function until(is, what) {
  for (let tried = 0; tried < 600; tried += 1) {
    if (is()) return;
    await new Promise((done) => setTimeout(done, 50));
  }
  throw new Error(`waited in vain for ${what}: ${state.output.join('\n')}`);
}

module.exports = { api, state, open, change, set, until };
